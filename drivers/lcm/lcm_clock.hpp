// SPDX-License-Identifier: MIT
// The two clocks of a host: senders over LCM stamp with the wall clock, cameras with the monotonic one.
#pragma once
#include <chrono>
#include <cstdint>
#include <limits>

#include "core/base/steady_time.hpp"

namespace loopsift {

inline constexpr std::int64_t kLatestUtime_us = std::numeric_limits<std::int64_t>::max() / 1000;

/// What is added to nanoseconds of the wall clock to have those of the monotonic one: one value for the whole
/// process, from the first call on, so that a clock that is set does not tear streams apart. Any thread.
[[nodiscard]] inline std::int64_t wall_to_monotonic_ns() {
  static const std::int64_t offset_ns = [] {
    const auto wall = std::chrono::system_clock::now().time_since_epoch();
    return steady_now_ns() - std::chrono::duration_cast<std::chrono::nanoseconds>(wall).count();
  }();
  return offset_ns;
}

}  // namespace loopsift
