// Files: reading, and writing so that a target is either its old content or its new, never a part.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tsc/gltf.h"

namespace tsc {

/// The file behind a relative URI of an asset in `folder`. Raises kInvalidInput (naming `place`) for a URI with a
/// scheme, and for one that leads out of the folder (by "..", an absolute path or a symbolic link) unless
/// `allow_external`. The file need not exist.
std::filesystem::path resolveUri(std::string_view uri, const std::filesystem::path& folder, bool allow_external,
                                 std::string_view place);

/// The file name's extension in small letters: ".glb" of "A.GLB".
std::string lowerExtension(const std::filesystem::path& path);

/// A file descriptor, closed on every way out.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  ~Descriptor();
  int get() const { return value_; }
  /// Closes now, for the errors that only close reports.
  bool close();

 private:
  int value_;
};

/// Files that appear together: each is written and flushed in the folder of its target first; `commit` puts them all
/// in their places, in the order in which they were added. Whatever has not been committed is removed by the
/// destructor. Where the file system can, files have no name until they are complete, so that a process that is killed
/// leaves nothing behind either.
class FileBatch {
 public:
  FileBatch() = default;
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  ~FileBatch();

  /// Writes and flushes `bytes` beside `target`. Raises kUsage if the target exists and not `force`, kIo.
  void add(const std::filesystem::path& target, std::span<const std::byte> bytes, bool force);
  /// Puts every file in its place. Raises kIo.
  void commit();

 private:
  struct Pending {
    Descriptor nameless;              ///< the file itself while it has no name, or -1
    std::filesystem::path temporary;  ///< its name beside the target, if it has one
    std::filesystem::path target;
    bool force = false;
  };
  static void place(Pending& file);

  std::vector<Pending> pending_;
  std::vector<std::filesystem::path> created_;  ///< targets that did not exist before `commit`
};

}  // namespace tsc
