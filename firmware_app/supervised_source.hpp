// SPDX-License-Identifier: MIT
// A source that comes back: a live one that is lost, or falls silent, is closed and opened again until it is
// there or the tries are used up. A recording is passed through as it is.
//
// In: an open source and how to open it again. Out: its frames; each carries the number of the opening that
// it comes from (RawFrame::session), so that who maps knows that it saw nothing of the way in between. Time
// stamps and frame numbers go on increasing, whatever the source that came back says.
//
// Threads: read() on the capture thread, which never opens or closes anything: a thread of its own does
// (start()), under normal scheduling, because drivers take memory, start threads and may hang in both.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/base/semaphore.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/retry_options.hpp"

namespace loopsift {

using SourceOpener = std::function<Expected<std::unique_ptr<FrameSource>>()>;

class SupervisedSource final : public FrameSource {
 public:
  /// `source` has been opened by `open`, which is called on another thread.
  SupervisedSource(std::unique_ptr<FrameSource> source, SourceOpener open, const RetryOptions& options);
  /// Waits for the opening thread, if end() has not been asked for before or did not succeed.
  ~SupervisedSource() override;

  /// Starts the opening thread, where there is something to open again. Set-up only.
  void start();
  /// Ends it. False when it has not ended within limit_ms, a driver being at fault: this object must then be
  /// kept for ever. After the reading has ended.
  [[nodiscard]] bool end(int limit_ms);

  /// That of the first opening: a source that comes back with other images is refused.
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  /// kTimeout while the source is away; kLost once the tries are used up. Makes no heap call but the
  /// source's.
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override;

  // Any thread.
  /// Lost or silent, and not yet back with a frame.
  [[nodiscard]] bool away() const { return away_; }
  /// How often it came back with a frame.
  [[nodiscard]] int returns() const { return returns_; }
  /// Whether the next read() is the first of an opening, for which its driver may take memory.
  [[nodiscard]] bool warming() const { return warming_; }

 private:
  void take(RawFrame* frame);
  void join_to_last(const RawFrame& first);
  void let_go(const char* why);
  [[nodiscard]] ReadStatus wait_for_return(int timeout_ms);
  [[nodiscard]] bool is_stalled() const;
  // Opening thread.
  void run();
  void open_again();
  [[nodiscard]] bool try_to_open(std::string* problem);

  const SourceOpener open_;
  const RetryOptions options_;
  const SourceInfo info_;
  std::thread thread_;
  Semaphore lost_or_stop_, back_or_given_up_;
  std::atomic<bool> stopping_{false}, ended_{false}, away_{false}, warming_{true};
  std::atomic<int> returns_{0}, tries_{0};  // tries since the last frame

  // Handed over with the semaphores: to the opening thread what was lost and why, back what came instead;
  // null: nothing did, and why.
  std::unique_ptr<FrameSource> handed_;
  std::string why_;

  // Capture thread's.
  std::unique_ptr<FrameSource> source_;  // null while it is away
  bool given_up_ = false;
  std::int32_t session_ = 0;
  std::int64_t silent_since_ns_ = 0;  // steady clock; 0: not read yet
  std::int64_t last_timestamp_ns_ = 0, last_arrival_ns_ = 0, clock_shift_ns_ = 0;
  std::int64_t last_sequence_ = -1, sequence_shift_ = 0;
};

/// Opens a source at the start, trying options.first_retry_limit times more where it may still come (a
/// camera, not a recording). Returns early, with the last error, when `stop` becomes true.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_patiently(const SourceOpener& open,
                                                                    const RetryOptions& options,
                                                                    const std::atomic<bool>& stop);

}  // namespace loopsift
