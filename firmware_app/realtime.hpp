// SPDX-License-Identifier: MIT
// What the process asks of the operating system before its threads start: real-time scheduling, locked
// memory, small stacks, a heap that neither grows nor shrinks. Thread: main, at set-up. Allocates.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "firmware_app/settings.hpp"
#include "firmware_app/thread_monitor.hpp"

namespace loopsift {

/// What was granted, and for what was not: what it takes, for a person (empty when all was).
struct RealtimeRights {
  bool scheduling = false;
  bool memory_locked = false;
  std::string warning;
};

/// Locks memory and tries real-time scheduling as far as `settings` want them. `live`: frames come at the
/// pace of the world; without that real-time scheduling is not asked for, since a thread that never waits
/// would starve the machine.
[[nodiscard]] RealtimeRights prepare_realtime(const ThreadSettings& settings, bool live);

/// By ThreadRole.
[[nodiscard]] std::array<ThreadPlan, kThreadCount> thread_plans(const Settings& settings,
                                                                const RealtimeRights& rights);

/// Bytes of stack of every thread made after limit_stacks().
inline constexpr std::size_t kStackBytes = std::size_t{1} << 20;
void limit_stacks();

/// Reads the program's own code (not its libraries') once: what is used only later, as that of the back
/// thread's solves, is resident from the start.
void load_program_code();

/// Makes the heap's first `bytes` resident and keeps them: later calls are served from them without a page
/// fault, and the heap gives nothing back to the system. All threads share one heap from then on. Call before
/// any thread starts.
void warm_heap(std::size_t bytes);

/// Memory of the process that is resident now.
[[nodiscard]] std::int64_t resident_bytes();

}  // namespace loopsift
