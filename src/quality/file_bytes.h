// Whole files in and out, and a scanner for the text formats.
#pragma once

#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tsc/quality.h"

namespace tsc {

inline Measured<std::string> readFileBytes(const std::filesystem::path& path) {
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored)) {
    return QualityError{QualityErrorCode::kUnreadableFile, path.string() + ": cannot be opened"};
  }
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return QualityError{QualityErrorCode::kUnreadableFile, path.string() + ": cannot be read"};
  return bytes;
}

/// Written beside its target and renamed; nothing is left behind on failure.
inline std::optional<QualityError> writeFileBytes(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path partial = path;
  partial += ".partial";
  std::ofstream file(partial, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) {
    std::filesystem::rename(partial, path, error);
    if (!error) return std::nullopt;
  }
  std::filesystem::remove(partial, error);
  return QualityError{QualityErrorCode::kUnreadableFile, path.string() + ": cannot be written"};
}

/// Words and numbers of a text, separated by blanks and line ends.
class TextScanner {
 public:
  explicit TextScanner(std::string_view text) : text_(text) {}

  /// The next line without its end; nothing at the end of the text.
  std::optional<std::string_view> line() {
    if (at_ >= text_.size()) return std::nullopt;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view result = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    if (!result.empty() && result.back() == '\r') result.remove_suffix(1);
    return result;
  }

  /// The next word; empty at the end.
  std::string_view word() {
    constexpr std::string_view kBlanks = " \t\r\n\v\f";
    const std::size_t begin = std::min(text_.find_first_not_of(kBlanks, at_), text_.size());
    at_ = std::min(text_.find_first_of(kBlanks, begin), text_.size());
    return text_.substr(begin, at_ - begin);
  }

  [[nodiscard]] std::size_t position() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

/// The whole word as a number; nothing if it is not one.
template <class T>
std::optional<T> parseNumber(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// Adds a polygon as a fan around its first corner.
inline void addFan(const std::vector<std::uint32_t>& polygon, std::vector<std::uint32_t>& indices) {
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    indices.insert(indices.end(), {polygon[0], polygon[k - 1], polygon[k]});
  }
}

/// The mesh in the content of a PLY file.
Measured<NamedSurface> parsePly(std::string_view bytes);

}  // namespace tsc
