// SPDX-License-Identifier: MIT
// The host clock that latencies are measured with and waits are timed by.
#pragma once
#include <chrono>
#include <cstdint>

namespace loopsift {

/// Nanoseconds of the monotonic clock (CLOCK_MONOTONIC). Any thread; never allocates.
[[nodiscard]] inline std::int64_t steady_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace loopsift
