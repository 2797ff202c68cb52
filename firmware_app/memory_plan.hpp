// SPDX-License-Identifier: MIT
// How much memory a run takes, known before it takes any. Thread: main, at set-up. Allocates.
#pragma once
#include <cstddef>
#include <optional>

#include "core/base/memory_budget.hpp"
#include "firmware_app/failure.hpp"
#include "firmware_app/settings.hpp"
#include "firmware_app/supervised_source.hpp"

namespace loopsift {

/// The budget of a run, and how much of it the arena has.
struct MemoryPlan {
  MemoryBudget budget;
  std::size_t arena_bytes = 0;
};

/// What the back thread may hold (memory.back_heap_mib), and a quarter more for what lies between its blocks.
[[nodiscard]] std::size_t heap_region_bytes(const Settings& settings);

/// Fills `plan`, also when it is over the cap (a Failure that has the rows). To be called with the source
/// open, and the program's code loaded (realtime.hpp): both count.
[[nodiscard]] std::optional<Failure> measure(const Settings& settings, SupervisedSource& source,
                                             MemoryPlan* plan);

}  // namespace loopsift
