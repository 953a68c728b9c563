// A progress bar on standard error: only on a terminal, only for work that lasts over a second.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

namespace tsc::cli {

class Progress {
 public:
  /// Starts to watch; a bar appears after a second. Nothing happens if not `enabled` or standard error is no terminal.
  Progress(std::string label, bool enabled);
  ~Progress();  ///< wipes the bar

  /// From any thread.
  void update(std::uint64_t done, std::uint64_t total);

 private:
  void draw();
  void watch();

  std::string label_;
  std::atomic<std::uint64_t> done_ = 0;
  std::atomic<std::uint64_t> total_ = 0;
  std::mutex mutex_;  // guards stop_
  std::condition_variable stopped_;
  bool stop_ = false;
  std::thread watcher_;  // not running if nothing is to be shown
};

}  // namespace tsc::cli
