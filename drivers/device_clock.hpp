// SPDX-License-Identifier: MIT
// Device time stamps on the host's clock. In: a frame's device time and when it arrived. Out: its time on
// CLOCK_MONOTONIC, strictly increasing. Thread: its owner's; never allocates.
#pragma once
#include <algorithm>
#include <cstdint>

namespace loopsift {

/// For a device with a clock of its own. A frame's delay on its way to the host is never negative, so the
/// offset between the clocks is the smallest difference of arrival and device time seen so far; it may rise
/// by 200 parts per million, so that it follows clocks that drift apart. It falls by at most half of the
/// device's step at a time, so that the mapped times go on increasing and keep at least half of each step. A
/// device clock that differs by more than a second from what the host measured since the last frame has
/// jumped: the mapping starts anew.
class DeviceClock {
 public:
  static constexpr std::int64_t kJumpNs = 1'000'000'000;
  static constexpr std::int64_t kDriftDivisor = 5000;  ///< 200 parts per million

  /// Writes the frame's time on the host's clock. False, and nothing changes, when the device's time is not
  /// after that of the frame before. A device time of 0 is none: the arrival stands in for it.
  [[nodiscard]] bool map(std::int64_t device_ns, std::int64_t arrival_ns, std::int64_t* host_ns) {
    const std::int64_t step_ns = device_ns - last_device_ns_;
    if (device_ns == 0 || !has_last_ || jumped(step_ns, arrival_ns - last_arrival_ns_)) {
      // A frame in line after one that was mapped too late must still come after it.
      const std::int64_t earliest_ns = has_last_ ? std::max(arrival_ns, last_host_ns_ + 1) : arrival_ns;
      offset_ns_ = earliest_ns - device_ns;
    } else if (step_ns <= 0) {
      return false;
    } else {
      const std::int64_t highest = offset_ns_ + step_ns / kDriftDivisor, lowest = offset_ns_ - step_ns / 2;
      offset_ns_ = std::clamp(arrival_ns - device_ns, lowest, highest);
    }
    *host_ns = device_ns + offset_ns_;
    has_last_ = true;
    last_device_ns_ = device_ns;
    last_arrival_ns_ = arrival_ns;
    last_host_ns_ = *host_ns;
    return true;
  }

 private:
  [[nodiscard]] static bool jumped(std::int64_t device_step_ns, std::int64_t host_step_ns) {
    const std::int64_t difference_ns = device_step_ns - host_step_ns;
    return difference_ns > kJumpNs || difference_ns < -kJumpNs;
  }

  bool has_last_ = false;
  std::int64_t offset_ns_ = 0;  // host − device
  std::int64_t last_device_ns_ = 0, last_arrival_ns_ = 0, last_host_ns_ = 0;
};

}  // namespace loopsift
