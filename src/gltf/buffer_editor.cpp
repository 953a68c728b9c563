// See buffer_editor.h.
#include "buffer_editor.h"

#include <algorithm>
#include <map>

#include "data_access.h"
#include "fault.h"
#include "json_document.h"
#include "references.h"

namespace tsc {
namespace {

using Source = Buffer::Source;

/// Ids of new views start here, far above any index.
constexpr std::uint64_t kFirstId = std::uint64_t{1} << 40;

/// What every range in a buffer may rely on: removing bytes moves the rest by multiples of this.
constexpr std::uint64_t kAlignment = 8;
constexpr std::uint64_t kViewAlignment = 4;

struct PlacedRange {
  std::size_t buffer;
  std::uint64_t begin;
  std::uint64_t end;
};

PlacedRange readRange(const Json& range, std::size_t view) {
  const JsonView json(range, "/bufferViews/" + std::to_string(view));
  const std::uint64_t begin = json.uintOr("byteOffset", 0);
  const std::uint64_t length = json["byteLength"].asUint();
  if (length > UINT64_MAX - begin) failInvalid(json.pointer(), "byteOffset and byteLength overflow");
  return {static_cast<std::size_t>(json["buffer"].asUint()), begin, begin + length};
}

template <class Range>
std::vector<Range> merged(std::vector<Range> ranges) {
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
  std::vector<Range> out;
  for (const Range& range : ranges) {
    if (range.begin >= range.end) continue;
    if (!out.empty() && range.begin <= out.back().end) {
      out.back().end = std::max(out.back().end, range.end);
    } else {
      out.push_back(range);
    }
  }
  return out;
}

/// What `ranges` cover and `holes` do not. Both merged.
template <class Range>
std::vector<Range> subtracted(const std::vector<Range>& ranges, const std::vector<Range>& holes) {
  std::vector<Range> out;
  std::size_t hole = 0;
  for (const Range& range : ranges) {
    std::uint64_t at = range.begin;
    while (hole < holes.size() && holes[hole].end <= at) ++hole;
    for (std::size_t h = hole; h < holes.size() && holes[h].begin < range.end; ++h) {
      if (holes[h].begin > at) out.push_back({at, holes[h].begin});
      at = std::max(at, holes[h].end);
    }
    if (at < range.end) out.push_back({at, range.end});
  }
  return out;
}

}  // namespace

BufferEditor::BufferEditor(Asset& asset)
    : asset_(asset), unknown_(unknownNumbers(asset.document)), used_before_(usedViews()) {}

std::set<std::size_t> BufferEditor::usedViews() {
  std::set<std::size_t> used;
  visitBufferViewReferences(asset_.document, [&](Json& index) { used.insert(*wholeNumber(index)); });
  return used;
}

std::set<std::size_t> BufferEditor::referencedBuffers() {
  std::set<std::size_t> buffers;
  visitBufferRanges(asset_.document,
                    [&](Json& range, std::size_t view) { buffers.insert(readRange(range, view).buffer); });
  return buffers;
}

std::uint64_t BufferEditor::add(Json properties, Place place) {
  NewView view;
  view.properties = std::move(properties);
  view.place = place;
  new_.push_back(std::move(view));
  return kFirstId + new_.size() - 1;
}

std::vector<std::byte>& BufferEditor::bytes(std::uint64_t id) { return new_[id - kFirstId].bytes; }

void BufferEditor::makePlaceholder(std::uint64_t id, std::uint64_t byte_length) {
  new_[id - kFirstId].placeholder = true;
  new_[id - kFirstId].placeholder_length = byte_length;
}

void BufferEditor::replace(std::size_t view, std::vector<std::byte> bytes) {
  replaced_.push_back({view, std::move(bytes)});
}

void BufferEditor::trim(std::size_t index, std::uint64_t begin, std::uint64_t end) {
  Json& view = asset_.document["bufferViews"][index];
  const PlacedRange range = readRange(view, index);
  trimmed_.push_back({range.buffer, {range.begin, range.end}});
  if (begin != 0) view["byteOffset"] = range.begin + begin;
  view["byteLength"] = end - begin;
}

std::vector<bool> BufferEditor::droppedViews() {
  const std::set<std::size_t> used = usedViews();
  std::vector<bool> dropped(countOf(asset_.document, "bufferViews"));
  for (const std::size_t view : used_before_) {
    if (view < dropped.size())
      dropped[view] = used.count(view) == 0 && (unknown_.count(view) == 0 || released_.count(view) > 0);
  }
  return dropped;
}

/// A replaced view that keeps its length and has real bytes is written where it is.
void BufferEditor::overwriteInPlace() {
  std::vector<Replacement> remaining;
  for (Replacement& replacement : replaced_) {
    const PlacedRange range = readRange(asset_.document["bufferViews"][replacement.view], replacement.view);
    const bool real =
        range.buffer < asset_.buffers.size() && asset_.buffers[range.buffer].source != Source::kPlaceholder;
    if (!real || range.end - range.begin != replacement.bytes.size()) {
      remaining.push_back(std::move(replacement));
      continue;
    }
    Buffer& buffer = asset_.buffers[range.buffer];
    if (range.end > buffer.bytes.size()) {
      failInvalid("/bufferViews/" + std::to_string(replacement.view), "ends outside its buffer");
    }
    const auto target = buffer.bytes.begin() + static_cast<std::ptrdiff_t>(range.begin);
    if (!std::equal(replacement.bytes.begin(), replacement.bytes.end(), target)) {
      std::copy(replacement.bytes.begin(), replacement.bytes.end(), target);
      buffer.modified = true;
    }
  }
  replaced_ = std::move(remaining);
}

void BufferEditor::releaseBytes(const std::vector<bool>& dropped) {
  std::set<std::size_t> moved;
  for (const Replacement& replacement : replaced_) moved.insert(replacement.view);
  std::vector<std::vector<Range>> released(asset_.buffers.size());
  std::vector<std::vector<Range>> kept(asset_.buffers.size());
  visitBufferRanges(asset_.document, [&](Json& json, std::size_t view) {
    const PlacedRange range = readRange(json, view);
    if (range.buffer >= asset_.buffers.size()) {
      failInvalid(
          "/bufferViews/" + std::to_string(view) + "/buffer",
          "found " + std::to_string(range.buffer) + ", expected one below " + std::to_string(asset_.buffers.size()));
    }
    auto& list = dropped[view] || moved.count(view) > 0 ? released : kept;
    list[range.buffer].push_back({range.begin, range.end});
  });
  for (const TrimmedRange& trimmed : trimmed_) {
    if (trimmed.buffer < released.size()) released[trimmed.buffer].push_back(trimmed.range);
  }
  for (std::size_t i = 0; i < asset_.buffers.size(); ++i) {
    if (asset_.buffers[i].source != Source::kPlaceholder && !released[i].empty()) {
      compactBuffer(i, merged(std::move(released[i])), merged(std::move(kept[i])));
    }
  }
}

void BufferEditor::compactBuffer(std::size_t index, std::vector<Range> released, std::vector<Range> kept) {
  std::vector<std::byte>& bytes = asset_.buffers[index].bytes;
  const std::uint64_t size = bytes.size();
  for (Range& range : released) range = {std::min(range.begin, size), std::min(range.end, size)};
  // Padding after a released range goes with it: a few zero bytes that no view covers.
  for (std::size_t i = 0; i < released.size(); ++i) {
    const std::uint64_t end = released[i].end;
    const auto next_kept = std::lower_bound(kept.begin(), kept.end(), end,
                                            [](const Range& range, std::uint64_t at) { return range.end <= at; });
    std::uint64_t limit = next_kept == kept.end() ? size : std::max(next_kept->begin, end);
    if (i + 1 < released.size()) limit = std::min(limit, released[i + 1].begin);
    const bool zero = std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(end),
                                  bytes.begin() + static_cast<std::ptrdiff_t>(std::min(limit, end + kAlignment)),
                                  [](std::byte b) { return b == std::byte{0}; });
    if (limit < end + kAlignment && zero) released[i].end = limit;
  }
  std::vector<Range> removed;
  for (const Range& free : subtracted(merged(released), kept)) {
    const std::uint64_t length =
        free.end == size ? free.end - free.begin : (free.end - free.begin) / kAlignment * kAlignment;
    removed.push_back({free.begin, free.begin + length});
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(free.begin + length),
              bytes.begin() + static_cast<std::ptrdiff_t>(free.end), std::byte{0});
  }
  if (removed.empty()) return;
  std::vector<std::byte> compacted;
  compacted.reserve(size);
  std::uint64_t at = 0;
  for (const Range& range : removed) {
    compacted.insert(compacted.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(range.begin));
    at = range.end;
  }
  compacted.insert(compacted.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end());
  bytes = std::move(compacted);
  asset_.buffers[index].modified = true;
  std::vector<std::uint64_t> removed_before(removed.size() + 1, 0);
  for (std::size_t i = 0; i < removed.size(); ++i) {
    removed_before[i + 1] = removed_before[i] + removed[i].end - removed[i].begin;
  }
  visitBufferRanges(asset_.document, [&](Json& json, std::size_t view) {
    const PlacedRange range = readRange(json, view);
    if (range.buffer != index) return;
    const auto after = std::upper_bound(removed.begin(), removed.end(), range.begin,
                                        [](std::uint64_t begin, const Range& r) { return begin < r.begin; });
    const std::uint64_t shift = removed_before[static_cast<std::size_t>(after - removed.begin())];
    if (shift != 0 && range.begin >= shift) json["byteOffset"] = range.begin - shift;
  });
}

/// The first buffer with bytes, or a new one.
std::size_t BufferEditor::targetBuffer() {
  for (std::size_t i = 0; i < asset_.buffers.size(); ++i) {
    if (asset_.buffers[i].source != Source::kPlaceholder) return i;
  }
  asset_.buffers.emplace_back();
  asset_.buffers.back().modified = true;
  asset_.document["buffers"].push_back(Json{{"byteLength", 0}});
  return asset_.buffers.size() - 1;
}

std::uint64_t BufferEditor::append(std::size_t buffer, std::span<const std::byte> bytes) {
  Buffer& target = asset_.buffers[buffer];
  target.bytes.resize((target.bytes.size() + kViewAlignment - 1) / kViewAlignment * kViewAlignment);
  const std::uint64_t offset = target.bytes.size();
  target.bytes.insert(target.bytes.end(), bytes.begin(), bytes.end());
  target.modified = true;
  return offset;
}

Json BufferEditor::makeView(NewView& view, std::size_t target) {
  Json json = Json::object();
  if (view.placeholder) {
    placeholder_bytes_ = (placeholder_bytes_ + kViewAlignment - 1) / kViewAlignment * kViewAlignment;
    json["buffer"] = asset_.buffers.size();  // the placeholder buffer, added last
    json["byteOffset"] = placeholder_bytes_;
    json["byteLength"] = view.placeholder_length;
    placeholder_bytes_ += view.placeholder_length;
  } else {
    json["buffer"] = target;
    json["byteOffset"] = append(target, view.bytes);
    json["byteLength"] = view.bytes.size();
    view.bytes = {};
  }
  for (auto& [key, value] : view.properties.items()) json[key] = value;
  return json;
}

void BufferEditor::placeViews(const std::vector<bool>& dropped) {
  constexpr std::size_t kGone = SIZE_MAX;
  const std::size_t target = targetBuffer();
  for (Replacement& replacement : replaced_) {
    Json& view = asset_.document["bufferViews"][replacement.view];
    const std::uint64_t offset = append(target, replacement.bytes);
    if (view["buffer"] != target) view["buffer"] = target;
    if (offset != 0 || view.contains("byteOffset")) view["byteOffset"] = offset;
    if (view["byteLength"] != replacement.bytes.size()) view["byteLength"] = replacement.bytes.size();
  }
  Json& views = asset_.document["bufferViews"];
  if (!views.is_array()) views = Json::array();
  std::vector<std::size_t> free_slots;
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    if (dropped[i]) free_slots.push_back(i);
  }
  std::size_t next_free = 0;
  for (const Place place : {Place::kAnywhere, Place::kLast}) {
    for (NewView& view : new_) {
      if (view.place != place) continue;
      Json json = makeView(view, target);
      if (place == Place::kAnywhere && next_free < free_slots.size()) {
        view.slot = free_slots[next_free++];
        views[view.slot] = std::move(json);
      } else {
        view.slot = views.size();
        views.push_back(std::move(json));
      }
    }
  }
  while (next_free < free_slots.size() && free_slots.back() + 1 == views.size() &&
         released_.count(free_slots.back()) > 0) {
    views.erase(views.size() - 1);
    free_slots.pop_back();
  }
  // Slots that nobody took are removed where that renumbers nothing that an unknown extension could name; otherwise
  // they stay as views of a few bytes.
  std::vector<std::size_t> new_index(views.size());
  std::size_t next = 0;
  const bool may_renumber = next_free == free_slots.size() ||
                            unknown_.lower_bound(free_slots[next_free]) == unknown_.end() ||
                            *unknown_.lower_bound(free_slots[next_free]) >= views.size();
  Json compacted = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const bool is_free =
        next_free < free_slots.size() &&
        std::binary_search(free_slots.begin() + static_cast<std::ptrdiff_t>(next_free), free_slots.end(), i);
    if (is_free && may_renumber) {
      new_index[i] = kGone;
      continue;
    }
    if (is_free) {
      const std::vector<std::byte> dead(kViewAlignment);
      views[i] = Json{{"buffer", target}, {"byteOffset", append(target, dead)}, {"byteLength", kViewAlignment}};
    }
    new_index[i] = next++;
    compacted.push_back(std::move(views[i]));
  }
  views = std::move(compacted);
  visitBufferViewReferences(asset_.document, [&](Json& index) {
    std::uint64_t value = *wholeNumber(index);
    if (value >= kFirstId && value - kFirstId < new_.size()) value = new_[value - kFirstId].slot;
    if (value < new_index.size() && new_index[value] != kGone) value = new_index[value];
    if (index != value) index = value;
  });
  if (views.empty()) asset_.document.erase("bufferViews");
}

void BufferEditor::removeEmptyBuffers(const std::set<std::size_t>& referenced_before) {
  const std::set<std::size_t> referenced = referencedBuffers();
  std::vector<BufferMove> moves(asset_.buffers.size() + 1);  // one more: the placeholder buffer still to come
  Json entries = Json::array();
  std::vector<Buffer> buffers;
  for (std::size_t i = 0; i < asset_.buffers.size(); ++i) {
    Buffer& buffer = asset_.buffers[i];
    const bool empty = buffer.source == Source::kPlaceholder || buffer.bytes.empty();
    const bool was_ours = referenced_before.count(i) > 0 || buffer.source == Source::kMemory;
    Json& entry = asset_.document["buffers"][i];
    moves[i] = {buffers.size(), 0};
    // Our own placeholder is the last buffer: without it, no other gets another number.
    const bool is_last_placeholder = i + 1 == asset_.buffers.size() && findExtension(entry, kExtensionName) != nullptr;
    const bool renumbers_none = is_last_placeholder || unknown_.lower_bound(i) == unknown_.end();
    if (empty && was_ours && referenced.count(i) == 0 && renumbers_none) continue;
    if (buffer.source != Source::kPlaceholder) {
      if (buffer.bytes.empty()) buffer.bytes.resize(kViewAlignment);
      if (entry["byteLength"] != buffer.bytes.size()) entry["byteLength"] = buffer.bytes.size();
    }
    entries.push_back(std::move(entry));
    buffers.push_back(std::move(buffer));
  }
  moves[asset_.buffers.size()] = {buffers.size(), 0};
  asset_.buffers = std::move(buffers);
  if (placeholder_bytes_ > 0) {
    Json entry = Json::object();
    entry["byteLength"] = placeholder_bytes_;
    entry["extensions"][std::string(kExtensionName)]["fallback"] = true;
    entries.push_back(std::move(entry));
    asset_.buffers.emplace_back();
    asset_.buffers.back().source = Source::kPlaceholder;
  }
  if (entries.empty()) {
    asset_.document.erase("buffers");
  } else {
    asset_.document["buffers"] = std::move(entries);
  }
  moveBuffers(asset_.document, moves);
}

void BufferEditor::commit() {
  const std::set<std::size_t> referenced_before = referencedBuffers();
  const std::vector<bool> dropped = droppedViews();
  const bool drops = std::find(dropped.begin(), dropped.end(), true) != dropped.end();
  if (new_.empty() && replaced_.empty() && trimmed_.empty() && !drops) return;
  overwriteInPlace();
  releaseBytes(dropped);
  placeViews(dropped);
  removeEmptyBuffers(referenced_before);
}

}  // namespace tsc
