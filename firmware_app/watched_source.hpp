// SPDX-License-Identifier: MIT
// A source as the watchdog sees it: each read is a piece of work of the capture thread, which is sealed after
// its first frame (until then decoders and devices may still take memory).
#pragma once
#include "drivers/frame_source.hpp"
#include "firmware_app/thread_monitor.hpp"

namespace loopsift {

class WatchedSource final : public FrameSource {
 public:
  /// Both must outlive this.
  WatchedSource(FrameSource& source, ThreadMonitor& monitor) : source_(source), monitor_(monitor) {}

  [[nodiscard]] const SourceInfo& info() const override { return source_.info(); }
  [[nodiscard]] const std::string& message() const override { return source_.message(); }

  ReadStatus read(RawFrame& frame, int timeout_ms) override {
    const WorkSpan span(&monitor_);
    const ReadStatus status = source_.read(frame, timeout_ms);
    if (status == ReadStatus::kFrame && tenure_ != nullptr) tenure_->seal_heap();
    return status;
  }

  /// Capture thread: its tenure, for as long as it reads.
  void begin(ThreadTenure* tenure) { tenure_ = tenure; }
  void end() { tenure_ = nullptr; }

 private:
  FrameSource& source_;
  ThreadMonitor& monitor_;
  ThreadTenure* tenure_ = nullptr;
};

}  // namespace loopsift
