// Files: reading, and writing so that a target is either its old content or its new, never a part.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tsc/gltf.h"

namespace tsc {

/// The file behind a relative URI of an asset in `folder`. Raises kInvalidInput (naming `place`) for a URI with a
/// scheme, and for one that leads out of the folder (by "..", an absolute path or a symbolic link) unless
/// `allow_external`. The file need not exist.
std::filesystem::path resolveUri(std::string_view uri, const std::filesystem::path& folder, bool allow_external,
                                 std::string_view place);

/// Files that appear together: each is written beside its target first; `commit` renames them all, in the order in
/// which they were added. Whatever has not been committed is removed by the destructor.
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
    std::filesystem::path temporary;
    std::filesystem::path target;
    bool force = false;
  };
  std::vector<Pending> pending_;
  std::vector<std::filesystem::path> created_;  ///< targets that did not exist before `commit`
};

}  // namespace tsc
