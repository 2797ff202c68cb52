// SPDX-License-Identifier: MIT
// Frame numbers and time stamps of a live device made fit to use: numbers that count up without end, and
// strictly increasing nanoseconds of the host's monotonic clock. In: what the device says about each frame,
// in order of arrival. One thread; never allocates.
#pragma once
#include <cstdint>

namespace loopsift {

/// A 32-bit frame counter taken as 64 bits. A counter that stands still or goes back (a device that does not
/// count, a stream that was started again) counts as one frame further.
class FrameCounter {
 public:
  [[nodiscard]] std::int64_t next(std::uint32_t device_count) {
    constexpr std::uint32_t kHalf = std::uint32_t{1} << 31;
    const std::uint32_t step = device_count - last_device_count_;  // modulo 2³²: the counter may wrap
    const bool forward = step != 0 && step < kHalf;
    count_ += count_ < 0 || !forward ? 1 : std::int64_t{step};
    last_device_count_ = device_count;
    return count_;
  }

 private:
  std::int64_t count_ = -1;
  std::uint32_t last_device_count_ = 0;
};

/// Device time stamps on the monotonic clock.
/// - Missing (0), in the future, which no frame can be that is here already, or so old that it must come from
///   another clock: the time of arrival instead.
/// - Not later than the stamp before: the frame cannot be used. After kMostBackward of these in a row the
///   device's clock has been set back for good, and times of arrival are taken from then on.
class LiveClock {
 public:
  static constexpr int kMostBackward = 10;
  static constexpr std::int64_t kOldestNs = 10'000'000'000;  ///< buffered while the reader slept, at most

  /// The stamp for a frame, or −1 when its time does not go forward.
  [[nodiscard]] std::int64_t stamp(std::int64_t device_ns, std::int64_t arrival_ns) {
    const bool usable = device_ns > 0 && device_ns <= arrival_ns && arrival_ns - device_ns <= kOldestNs &&
                        backward_ < kMostBackward;
    const std::int64_t stamp_ns = usable ? device_ns : arrival_ns;
    replaced_ += usable ? 0 : 1;
    if (stamp_ns <= last_ns_) {
      if (backward_ < kMostBackward) ++backward_;
      return -1;
    }
    if (backward_ < kMostBackward) backward_ = 0;
    last_ns_ = stamp_ns;
    return stamp_ns;
  }
  /// Frames whose own stamp was of no use.
  [[nodiscard]] std::int64_t replaced() const { return replaced_; }

 private:
  std::int64_t last_ns_ = 0, replaced_ = 0;
  int backward_ = 0;
};

}  // namespace loopsift
