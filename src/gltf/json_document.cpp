// See json_document.h.
#include "json_document.h"

#include <algorithm>
#include <cmath>

#include "fault.h"

namespace tsc {
namespace {

using DomBuilder = nlohmann::detail::json_sax_dom_parser<Json>;

std::string printByteOffset(std::size_t offset) { return "JSON byte " + std::to_string(offset); }

/// Builds the document, refusing what would not survive: duplicate keys and too many members.
class Builder : public DomBuilder {
 public:
  Builder(Json& root, std::uint32_t max_depth) : DomBuilder(root, /*allow_exceptions=*/false), max_depth_(max_depth) {}

  bool number_float(double value, const std::string& text) {
    const bool is_integer = text.find_first_of(".eE") == std::string::npos;
    if (!is_integer) return DomBuilder::number_float(value, text);
    Json::binary_t digits(std::vector<std::uint8_t>(text.begin(), text.end()));
    return DomBuilder::binary(digits);
  }

  bool start_object(std::size_t count) {
    enter();
    keys_.emplace_back();
    return DomBuilder::start_object(count);
  }
  bool end_object() {
    --depth_;
    keys_.pop_back();
    return DomBuilder::end_object();
  }
  bool start_array(std::size_t count) {
    enter();
    return DomBuilder::start_array(count);
  }
  bool end_array() {
    --depth_;
    return DomBuilder::end_array();
  }

  bool key(std::string& name) {
    std::vector<std::string>& seen = keys_.back();
    if (seen.size() >= kMaxObjectMembers) {
      fail(FailureKind::kUnsupported, "JSON",
           "found an object with more than " + std::to_string(kMaxObjectMembers) + " members");
    }
    if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
      failInvalid("JSON", "found the key \"" + name + "\" twice in one object, expected unique keys");
    }
    seen.push_back(name);
    return DomBuilder::key(name);
  }

  bool parse_error(std::size_t position, const std::string& last_token, const nlohmann::detail::exception& error) {
    std::string message = error.what();
    const std::size_t colon = message.find("; ");
    if (colon != std::string::npos) message = message.substr(colon + 2);
    (void)last_token;
    failInvalid(printByteOffset(position), "not valid JSON: " + message);
  }

 private:
  void enter() {
    if (++depth_ > max_depth_) {
      failInvalid("JSON", "nested deeper than " + std::to_string(max_depth_) + " levels");
    }
  }

  std::uint32_t depth_ = 0;
  std::uint32_t max_depth_;
  std::vector<std::vector<std::string>> keys_;
};

void newLine(std::string& out, int indent, int level) {
  if (indent < 0) return;
  out += '\n';
  out.append(static_cast<std::size_t>(indent) * static_cast<std::size_t>(level), ' ');
}

/// Whether an array reads best on one line.
bool isFlat(const Json& array) {
  return std::none_of(array.begin(), array.end(), [](const Json& value) { return value.is_structured(); });
}

void print(const Json& value, int indent, int level, std::string& out) {
  if (value.is_binary()) {
    const auto& digits = value.get_binary();
    out.append(digits.begin(), digits.end());
  } else if (value.is_object() && !value.empty()) {
    out += '{';
    bool first = true;
    for (const auto& [key, member] : value.items()) {
      if (!first) out += ',';
      first = false;
      newLine(out, indent, level + 1);
      out += Json(key).dump();
      out += indent < 0 ? ":" : ": ";
      print(member, indent, level + 1, out);
    }
    newLine(out, indent, level);
    out += '}';
  } else if (value.is_array() && !value.empty()) {
    const bool flat = isFlat(value);
    out += '[';
    bool first = true;
    for (const Json& element : value) {
      if (!first) out += indent >= 0 && flat ? ", " : ",";
      first = false;
      if (!flat) newLine(out, indent, level + 1);
      print(element, indent, level + 1, out);
    }
    if (!flat) newLine(out, indent, level);
    out += ']';
  } else {
    out += value.dump();
  }
}

Json* findMember(Json& holder, std::string_view key) {
  if (!holder.is_object()) return nullptr;
  const auto found = holder.find(std::string(key));
  return found == holder.end() ? nullptr : &*found;
}

void addOnce(Json& document, const char* list, std::string_view name) {
  Json& names = document[list];
  if (!names.is_array()) names = Json::array();
  const bool present = std::any_of(names.begin(), names.end(), [&](const Json& entry) { return entry == name; });
  if (!present) names.push_back(std::string(name));
}

}  // namespace

Json parseJson(std::string_view text, std::uint32_t max_depth) {
  Json root;
  Builder builder(root, max_depth);
  Json::sax_parse(text.begin(), text.end(), &builder);
  if (!root.is_object()) failInvalid("JSON", "found " + brief(root) + ", expected an object");
  return root;
}

std::string writeJson(const Json& document, int indent) {
  std::string out;
  print(document, indent, 0, out);
  return out;
}

std::string brief(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  constexpr std::size_t kLongest = 60;
  std::string text = writeJson(value);
  if (text.size() > kLongest) {
    // Not in the middle of a UTF-8 sequence.
    std::size_t end = kLongest;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
    text = text.substr(0, end) + "…";
  }
  return text;
}

void JsonView::wrongType(std::string_view expected) const {
  failInvalid(pointer_.empty() ? "JSON" : pointer_, "found " + brief(*value_) + ", expected " + std::string(expected));
}

std::optional<JsonView> JsonView::find(std::string_view key) const {
  if (!value_->is_object()) wrongType("an object");
  const auto found = value_->find(std::string(key));
  if (found == value_->end()) return std::nullopt;
  return JsonView(*found, pointer_ + "/" + std::string(key));
}

JsonView JsonView::operator[](std::string_view key) const {
  std::optional<JsonView> member = find(key);
  if (!member) failInvalid(pointer_ + "/" + std::string(key), "missing, but required");
  return *std::move(member);
}

std::size_t JsonView::size() const {
  if (!value_->is_array()) wrongType("an array");
  return value_->size();
}

JsonView JsonView::at(std::size_t index) const {
  if (index >= size()) {
    failInvalid(pointer_, "found index " + std::to_string(index) + ", expected one below " + std::to_string(size()));
  }
  return JsonView((*value_)[index], pointer_ + "/" + std::to_string(index));
}

std::optional<std::uint64_t> wholeNumber(const Json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (value.is_number_integer()) {
    const auto number = value.get<std::int64_t>();
    if (number < 0) return std::nullopt;
    return static_cast<std::uint64_t>(number);
  }
  if (!value.is_number_float()) return std::nullopt;
  const double real = value.get<double>();
  constexpr double kLargestExact = 9007199254740992.0;
  if (!(real >= 0 && real <= kLargestExact && std::floor(real) == real)) return std::nullopt;
  return static_cast<std::uint64_t>(real);
}

std::uint64_t JsonView::asUint(std::uint64_t max) const {
  const std::optional<std::uint64_t> number = wholeNumber(*value_);
  if (!number) wrongType("a whole number");
  if (*number > max) wrongType("at most " + std::to_string(max));
  return *number;
}

std::string JsonView::asString() const {
  if (!value_->is_string()) wrongType("a string");
  return value_->get<std::string>();
}

bool JsonView::asBool() const {
  if (!value_->is_boolean()) wrongType("true or false");
  return value_->get<bool>();
}

const Json& JsonView::asObject() const {
  if (!value_->is_object()) wrongType("an object");
  return *value_;
}

std::uint64_t JsonView::uintOr(std::string_view key, std::uint64_t otherwise, std::uint64_t max) const {
  const std::optional<JsonView> member = find(key);
  return member ? member->asUint(max) : otherwise;
}

JsonView elementOf(const Json& document, std::string_view key, std::size_t index) {
  return JsonView(document)[key].at(index);
}

std::size_t countOf(const Json& document, std::string_view key) {
  const std::optional<JsonView> array = JsonView(document).find(key);
  return array ? array->size() : 0;
}

const Json* findExtension(const Json& holder, std::string_view name) {
  if (!holder.is_object()) return nullptr;
  const auto extensions = holder.find("extensions");
  if (extensions == holder.end() || !extensions->is_object()) return nullptr;
  const auto extension = extensions->find(std::string(name));
  return extension == extensions->end() ? nullptr : &*extension;
}

void eraseExtension(Json& holder, std::string_view name) {
  Json* extensions = findMember(holder, "extensions");
  if (extensions == nullptr || !extensions->is_object()) return;
  if (extensions->erase(std::string(name)) > 0 && extensions->empty()) holder.erase("extensions");
}

void declareExtension(Json& document, std::string_view name, bool required) {
  addOnce(document, "extensionsUsed", name);
  if (required) addOnce(document, "extensionsRequired", name);
}

void undeclareExtension(Json& document, std::string_view name) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    Json* names = findMember(document, list);
    if (names == nullptr || !names->is_array()) continue;
    const std::size_t before = names->size();
    for (std::size_t i = names->size(); i-- > 0;) {
      if ((*names)[i] == name) names->erase(i);
    }
    if (before > 0 && names->empty()) document.erase(list);
  }
}

}  // namespace tsc
