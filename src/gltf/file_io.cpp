// See file_io.h. POSIX calls, because the standard library can neither flush to disk nor create exclusively.
#include "file_io.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "container.h"
#include "fault.h"

namespace tsc {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void failIo(const std::string& what, const fs::path& path, int error) {
  fail(FailureKind::kIo, "", "cannot " + what + " " + path.string() + ": " + std::strerror(error));
}

void writeAll(const Descriptor& file, std::span<const std::byte> bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      failIo("write", path, errno);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

/// Calls `create` with names in the target's folder until one is free; gives its result, -1 and errno if that fails.
template <class Create>
int underFreeName(const fs::path& target, fs::path& temporary, const Create& create) {
  constexpr int kAttempts = 1000;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const std::string run = std::to_string(::getpid()) + '-' + std::to_string(attempt);
    temporary = target.parent_path() / ('.' + target.filename().string() + '.' + run + ".part");
    const int result = create(temporary.c_str());
    if (result >= 0 || errno != EEXIST) return result;
  }
  errno = EEXIST;
  return -1;
}

std::string descriptorPath(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

/// A file without a name in the target's folder; -1 where the system has no such thing.
int createNameless(const fs::path& target) {
  const fs::path folder = target.parent_path();
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
  if (descriptor >= 0 && ::access(descriptorPath(descriptor).c_str(), F_OK) != 0) {
    ::close(descriptor);  // without /proc it could never get a name
    return -1;
  }
  return descriptor;
}

int nameFile(int descriptor, const char* name) {
  return ::linkat(AT_FDCWD, descriptorPath(descriptor).c_str(), AT_FDCWD, name, AT_SYMLINK_FOLLOW);
}

/// Makes a renamed entry durable. Best effort: some file systems refuse to flush a folder.
void flushFolder(const fs::path& folder) {
  const Descriptor descriptor(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.get() >= 0) (void)::fsync(descriptor.get());
}

/// Devices and pipes cannot be replaced by a rename, so they are written directly.
bool isSpecial(const fs::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

bool isInside(const fs::path& path, const fs::path& folder) {
  auto part = path.begin();
  for (const fs::path& expected : folder) {
    if (expected.empty()) continue;  // a trailing slash
    if (part == path.end() || *part != expected) return false;
    ++part;
  }
  return true;
}

bool hasScheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon < 2) return false;
  for (const char c : uri.substr(0, colon)) {
    const bool allowed =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    if (!allowed) return false;
  }
  return true;
}

}  // namespace

fs::path resolveUri(std::string_view uri, const fs::path& folder, bool allow_external, std::string_view place) {
  if (hasScheme(uri)) {
    fail(FailureKind::kUnsupported, place,
         "found the URI \"" + std::string(uri.substr(0, 80)) + "\", expected a relative one (nothing is fetched)");
  }
  const std::string name = percentDecode(uri);
  if (name.empty() || name.find('\0') != std::string::npos) failInvalid(place, "found an empty or impossible URI");
  // A file whose name really contains "%20" is preferred to one with a space only where it exists.
  fs::path path = folder / fs::path(name);
  std::error_code ignored;
  if (!fs::exists(path, ignored) && fs::exists(folder / fs::path(std::string(uri)), ignored)) {
    path = folder / fs::path(std::string(uri));
  }
  if (allow_external) return path;
  // Made absolute first, for what does not exist stays relative otherwise.
  const fs::path root = fs::weakly_canonical(fs::absolute(folder.empty() ? fs::path(".") : folder));
  if (!isInside(fs::weakly_canonical(fs::absolute(path)), root)) {
    failInvalid(place, "found the URI \"" + std::string(uri.substr(0, 80)) + "\", which leads out of the folder " +
                           root.string() + "; --allow-external follows it");
  }
  return path;
}

std::string lowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

Descriptor::~Descriptor() {
  if (value_ >= 0) ::close(value_);
}

bool Descriptor::close() { return ::close(std::exchange(value_, -1)) == 0; }

FileBatch::~FileBatch() {
  std::error_code ignored;
  for (const Pending& file : pending_) {
    if (!file.temporary.empty()) fs::remove(file.temporary, ignored);
  }
  for (const fs::path& target : created_) fs::remove(target, ignored);
}

void FileBatch::add(const fs::path& target, std::span<const std::byte> bytes, bool force) {
  std::error_code ignored;
  if (isSpecial(target)) {
    Descriptor file(::open(target.c_str(), O_WRONLY | O_CLOEXEC));
    if (file.get() < 0) failIo("open", target, errno);
    writeAll(file, bytes, target);
    if (!file.close()) failIo("write", target, errno);
    return;
  }
  if (fs::is_directory(target, ignored)) fail(FailureKind::kUsage, "", target.string() + " is a folder");
  if (!force && fs::exists(fs::symlink_status(target, ignored))) {
    fail(FailureKind::kUsage, "", target.string() + " exists already; force to replace it");
  }
  // A symbolic link keeps pointing where it does; the file behind it is replaced.
  const fs::path real = fs::is_symlink(target, ignored) ? fs::weakly_canonical(target) : target;
  Descriptor file(createNameless(real));
  const bool nameless = file.get() >= 0;
  fs::path temporary;
  if (!nameless) {
    file = Descriptor(underFreeName(
        real, temporary, [](const char* name) { return ::open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); }));
    if (file.get() < 0) failIo("create a file beside", target, errno);
  }
  pending_.push_back({Descriptor(-1), temporary, real, force});
  writeAll(file, bytes, target);
  struct stat old {};
  if (::stat(real.c_str(), &old) == 0) (void)::fchmod(file.get(), old.st_mode & 0777);
  if (::fsync(file.get()) != 0) failIo("flush", target, errno);
  if (nameless) {
    pending_.back().nameless = std::move(file);
  } else if (!file.close()) {
    failIo("write", target, errno);
  }
}

/// Gives a complete file the name of its target.
void FileBatch::place(Pending& file) {
  const bool nameless = file.nameless.get() >= 0;
  if (!file.force) {
    // A link fails where the target has come into being meanwhile, which a rename would overwrite.
    const int result = nameless ? nameFile(file.nameless.get(), file.target.c_str())
                                : ::link(file.temporary.c_str(), file.target.c_str());
    if (result == 0) {
      if (!nameless) ::unlink(file.temporary.c_str());
      return;
    }
    if (errno == EEXIST) fail(FailureKind::kUsage, "", file.target.string() + " exists already");
  }
  if (nameless) {
    const int result = underFreeName(file.target, file.temporary,
                                     [&](const char* name) { return nameFile(file.nameless.get(), name); });
    if (result != 0) failIo("create a file beside", file.target, errno);
  }
  if (::rename(file.temporary.c_str(), file.target.c_str()) != 0) failIo("write", file.target, errno);
}

void FileBatch::commit() {
  std::error_code ignored;
  while (!pending_.empty()) {
    Pending& file = pending_.front();
    const bool existed = fs::exists(file.target, ignored);
    place(file);
    if (!existed) created_.push_back(file.target);
    flushFolder(file.target.parent_path());
    pending_.erase(pending_.begin());
  }
  created_.clear();
}

Expected<std::vector<std::byte>> readFile(const fs::path& path, std::uint64_t max_bytes) {
  return guarded("", [&] {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) failIo("read", path, errno);
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) failIo("read", path, errno);
    if (S_ISDIR(status.st_mode)) failIo("read", path, EISDIR);
    std::vector<std::byte> bytes;
    if (S_ISREG(status.st_mode)) {
      bytes.reserve(std::min<std::uint64_t>(static_cast<std::uint64_t>(status.st_size), max_bytes) + 1);
    }
    constexpr std::size_t kBlock = std::size_t{1} << 20;
    for (;;) {
      const std::size_t at = bytes.size();
      if (at > max_bytes) {
        failInvalid(path.string(), "larger than " + std::to_string(max_bytes) + " bytes, the limit for input");
      }
      const std::size_t room = std::max(bytes.capacity() - at, S_ISREG(status.st_mode) ? std::size_t{1} : kBlock);
      bytes.resize(at + std::min(room, kBlock * 64));
      const ssize_t got = ::read(file.get(), bytes.data() + at, bytes.size() - at);
      bytes.resize(at + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got < 0 && errno != EINTR) failIo("read", path, errno);
      if (got == 0) return bytes;
    }
  });
}

Outcome writeFile(const fs::path& path, std::span<const std::byte> bytes, bool force) {
  return guardedOutcome("", [&] {
    FileBatch batch;
    batch.add(path, bytes, force);
    batch.commit();
  });
}

}  // namespace tsc
