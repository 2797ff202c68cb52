// SPDX-License-Identifier: MIT
// How a run feels at one moment: filled by the supervising (main) thread once a second from counters that the
// other threads keep, then copied to the publisher and to the terminal's line. One plain value of fixed size.
// Never allocates.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/odometry/odometry.hpp"
#include "core/pipeline/run_figures.hpp"

namespace loopsift {

enum class RunState : std::uint8_t {
  kStarting,   ///< no frame has come yet
  kTracking,   ///< the newest frame has a pose
  kLost,       ///< frames come, but the newest could not be tracked
  kNoSource,   ///< the camera is lost, or has given no frame for longer than watchdog.no_source_s
  kFinishing,  ///< the source ended or a stop was asked for; the last loops are sifted and files are written
};
inline constexpr std::array<const char*, 5> kRunStateNames = {"starting", "tracking", "lost", "no source",
                                                              "finishing"};
[[nodiscard]] inline const char* to_string(RunState state) {
  return kRunStateNames[static_cast<std::size_t>(state)];
}

/// The program's threads besides the supervising one.
enum class ThreadRole : std::uint8_t { kCapture, kFront, kBack, kPublish };
inline constexpr std::size_t kThreadCount = 4;
inline constexpr std::array<const char*, kThreadCount> kThreadNames = {"capture", "front", "back", "publish"};

struct RunHealth {
  static constexpr std::size_t kMaxPools = 24;
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

  struct Latency {
    float p50_ms = 0, p99_ms = 0, max_ms = 0;  ///< since the start
    std::int64_t count = 0;
  };
  struct Thread {
    std::int64_t deadline_misses = 0;  ///< pieces of work that took longer than the thread's deadline
    std::int64_t heap_calls = -1;      ///< since the heap was sealed; −1: this build does not count them
    bool realtime = false;             ///< runs under SCHED_FIFO
    bool disabled = false;             ///< hung and given up; only the back thread ever is
  };
  struct Pool {
    std::array<char, 32> name{};  ///< "part/what", zero-terminated
    std::int64_t capacity = 0, high_water = 0, refused = 0;
  };

  std::int64_t timestamp_ns = 0;  ///< of the newest frame; 0 before the first
  std::int64_t uptime_ns = 0;     ///< since the threads started
  RunState state = RunState::kStarting;
  LostReason lost_reason = LostReason::kNone;  ///< of the newest frame that was lost; kNone: none was
  bool anchored = true;  ///< false: tracking was lost, and no accepted loop joins what came after to the map

  std::int64_t frames_received = 0, frames_dropped = 0, frames_tracked = 0, frames_lost = 0;
  std::array<Latency, kStageCount> latency;  ///< by Stage
  std::array<Thread, kThreadCount> threads;  ///< by ThreadRole
  std::array<Pool, kMaxPools> pools;         ///< the first pool_count are valid
  std::int32_t pool_count = 0;

  std::int32_t fragments = 0;     ///< closed and kept
  std::int32_t back_backlog = 0;  ///< fragments that wait for the back thread, the one in work among them
  std::int32_t loops_proposed = 0, loops_accepted = 0;
  std::int32_t correction_epoch = 0;  ///< corrections applied

  std::int64_t resident_bytes = 0;     ///< of the process, now
  std::int64_t budget_bytes = 0;       ///< of all memory, as printed at the start
  std::int64_t fence_limit_bytes = 0;  ///< what the back thread's heap may hold
  std::int64_t fence_peak_bytes = -1;  ///< most that it held; −1: this build does not count
  std::int64_t fence_refusals = 0;     ///< solves and registrations that were refused memory

  float temperature_c = kUnknown;  ///< of the hottest thermal zone, where the board tells
  float clock_mhz = kUnknown;      ///< of the slowest core's clock, where the board tells
};

}  // namespace loopsift
