#include "progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

namespace tsc::cli {

using namespace std::chrono_literals;

Progress::Progress(std::string label, bool enabled) : label_(std::move(label)) {
  if (enabled && ::isatty(STDERR_FILENO) == 1) watcher_ = std::thread([this] { watch(); });
}

Progress::~Progress() {
  if (!watcher_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  stopped_.notify_all();
  watcher_.join();
}

void Progress::update(std::uint64_t done, std::uint64_t total) {
  done_ = done;
  total_ = total;
}

void Progress::draw() {
  constexpr int kWidth = 40;
  const double total = static_cast<double>(std::max<std::uint64_t>(total_, 1));
  const double share = std::min(1.0, static_cast<double>(done_) / total);
  const int filled = static_cast<int>(share * kWidth);
  fmt::print(stderr, "\r\033[K{} [{}{}] {:3.0f}%", label_, std::string(filled, '#'), std::string(kWidth - filled, '.'),
             100 * share);
  std::fflush(stderr);
}

void Progress::watch() {
  std::unique_lock lock(mutex_);
  if (stopped_.wait_for(lock, 1s, [this] { return stop_; })) return;
  do {
    draw();
  } while (!stopped_.wait_for(lock, 100ms, [this] { return stop_; }));
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
}

}  // namespace tsc::cli
