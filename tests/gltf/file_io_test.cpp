// Files: the old one or the new one, never a part of either, whatever happens on the way.
#include "file_io.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

namespace tsc::test {
namespace {

namespace fs = std::filesystem;

class FileIo : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tsc-file-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    target_ = folder_ / "a.glb";
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::vector<std::byte> bytes(std::size_t count, int value) {
    return std::vector<std::byte>(count, static_cast<std::byte>(value));
  }
  std::size_t fileCount() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  /// Runs `body` in a process of its own and gives what `waitpid` says.
  static int inChild(const std::function<int()>& body) {
    const pid_t child = fork();
    if (child == 0) _exit(body());
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    return status;
  }

  fs::path folder_, target_;
};

TEST_F(FileIo, AKilledProcessLeavesTheOldFile) {
  ASSERT_FALSE(writeFile(target_, bytes(10, 1), false));
  const int status = inChild([&] {
    FileBatch batch;
    batch.add(target_, bytes(100000, 2), true);
    return raise(SIGKILL);
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  const auto content = readFile(target_, 1000000);
  ASSERT_TRUE(content);
  EXPECT_EQ(*content, bytes(10, 1));
  EXPECT_EQ(fileCount(), 1U);
}

TEST_F(FileIo, ADiskThatIsFullLeavesTheOldFile) {
  ASSERT_FALSE(writeFile(target_, bytes(10, 1), false));
  const int status = inChild([&] {
    // A limit on the size of files fails in the same place as a full disk.
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
    const Outcome outcome = writeFile(target_, bytes(100000, 2), true);
    return outcome && outcome->kind == FailureKind::kIo ? 0 : 1;
  });
  EXPECT_EQ(status, 0);
  EXPECT_EQ(fs::file_size(target_), 10U);
  EXPECT_EQ(fileCount(), 1U);
  const Outcome full = writeFile("/dev/full", bytes(10, 1), true);
  ASSERT_TRUE(full);
  EXPECT_EQ(full->kind, FailureKind::kIo);
}

TEST_F(FileIo, AFolderThatCannotBeWrittenIsNamed) {
  if (geteuid() != 0) {
    fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
    const Outcome outcome = writeFile(target_, bytes(10, 1), false);
    fs::permissions(folder_, fs::perms::owner_all);
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->kind, FailureKind::kIo);
  }
  // Nobody, not even root, makes files here.
  const Outcome outcome = writeFile("/proc/self/a.glb", bytes(10, 1), false);
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->kind, FailureKind::kIo);
  EXPECT_NE(outcome->message.find("/proc/self/a.glb"), std::string::npos) << outcome->message;
}

TEST_F(FileIo, FilesAppearTogetherOrNotAtAll) {
  {
    FileBatch batch;
    batch.add(folder_ / "a.bin", bytes(10, 1), false);
    batch.add(target_, bytes(10, 2), false);
    EXPECT_FALSE(fs::exists(target_));
    // Somebody else takes the second name meanwhile.
    std::ofstream(target_) << "other";
    EXPECT_ANY_THROW(batch.commit());
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.bin"));
  EXPECT_EQ(fs::file_size(target_), 5U);
  EXPECT_EQ(fileCount(), 1U);
}

TEST_F(FileIo, TwoRunsOnOneTargetGiveOneOfTheirFiles) {
  const auto writeMany = [&](int value) {
    for (int i = 0; i < 50; ++i) EXPECT_FALSE(writeFile(target_, bytes(20000, value), true));
  };
  std::thread first(writeMany, 1), second(writeMany, 2);
  for (int i = 0; i < 50; ++i) {
    const auto content = readFile(target_, 1000000);
    if (!content) continue;
    EXPECT_TRUE(*content == bytes(20000, 1) || *content == bytes(20000, 2));
  }
  first.join();
  second.join();
  EXPECT_EQ(fileCount(), 1U);
}

TEST_F(FileIo, LinksAndPermissionsStay) {
  ASSERT_FALSE(writeFile(target_, bytes(10, 1), false));
  fs::permissions(target_, fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink(target_, folder_ / "link.glb");
  ASSERT_FALSE(writeFile(folder_ / "link.glb", bytes(20, 2), true));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.glb"));
  EXPECT_EQ(fs::file_size(target_), 20U);
  EXPECT_EQ(fs::status(target_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(FileIo, LargeInputIsRefused) {
  ASSERT_FALSE(writeFile(target_, bytes(100, 1), false));
  EXPECT_TRUE(readFile(target_, 100));
  const auto refused = readFile(target_, 99);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.failure().kind, FailureKind::kInvalidInput);
}

}  // namespace
}  // namespace tsc::test
