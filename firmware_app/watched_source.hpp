// SPDX-License-Identifier: MIT
// A source as the watchdog sees it: each read is a piece of work of the capture thread, which is sealed after
// the first frame of each opening (until then decoders and devices may still take memory). What it read is
// offered to the recorder.
#pragma once
#include <atomic>
#include <cstdint>

#include "core/base/steady_time.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/recorder.hpp"
#include "firmware_app/supervised_source.hpp"
#include "firmware_app/thread_monitor.hpp"

namespace loopsift {

class WatchedSource final : public FrameSource {
 public:
  /// Both must outlive this.
  WatchedSource(SupervisedSource& source, ThreadMonitor& monitor, FrameRecorder& recorder)
      : source_(source), monitor_(monitor), recorder_(recorder) {}

  [[nodiscard]] const SourceInfo& info() const override { return source_.info(); }
  [[nodiscard]] const std::string& message() const override { return source_.message(); }

  ReadStatus read(RawFrame& frame, int timeout_ms) override {
    const WorkSpan span(&monitor_);
    if (waiting_since_ns_ == 0) waiting_since_ns_ = steady_now_ns();
    if (source_.warming() && tenure_ != nullptr) tenure_->unseal_heap();
    const ReadStatus status = source_.read(frame, timeout_ms);
    if (status == ReadStatus::kFrame) waiting_since_ns_ = 0;
    if (status == ReadStatus::kFrame) recorder_.offer(frame);
    if (status == ReadStatus::kFrame && tenure_ != nullptr) tenure_->seal_heap();
    return status;
  }

  /// For how long the source has been asked for a frame without giving one. Any thread.
  [[nodiscard]] std::int64_t waiting_ns(std::int64_t now_ns) const {
    const std::int64_t since = waiting_since_ns_.load(std::memory_order_relaxed);
    return since == 0 || now_ns < since ? 0 : now_ns - since;
  }

  /// Whether a camera is lost, or open again without a frame. Any thread.
  [[nodiscard]] bool away() const { return source_.away(); }

  /// Capture thread: its tenure, for as long as it reads.
  void begin(ThreadTenure* tenure) { tenure_ = tenure; }
  void end() { tenure_ = nullptr; }

 private:
  SupervisedSource& source_;
  ThreadMonitor& monitor_;
  FrameRecorder& recorder_;
  ThreadTenure* tenure_ = nullptr;
  std::atomic<std::int64_t> waiting_since_ns_{0};
};

}  // namespace loopsift
