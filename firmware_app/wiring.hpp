// SPDX-License-Identifier: MIT
// The only place where the parts meet. In: settings. Out: a run from the source's first frame to the written
// results. Thread: main; starts and joins all others.
#pragma once
#include <atomic>
#include <optional>

#include "core/base/memory_budget.hpp"
#include "core/pipeline/settings.hpp"
#include "firmware_app/failure.hpp"
#include "firmware_app/progress.hpp"

namespace loopsift {

/// What a run with these settings reserves before its first frame; `budget` is filled also when it is over
/// the cap (a Failure). Opens the source to learn its image size; without one, 640×480 with colour is taken.
[[nodiscard]] std::optional<Failure> plan_memory(const Settings& settings, MemoryBudget* budget);

/// Runs until the source ends, is lost, or `stop` becomes true; in each case everything found so far is
/// written to settings.run.out. Nothing on success.
[[nodiscard]] std::optional<Failure> run(const Settings& settings, const std::atomic<bool>& stop,
                                         Progress* progress);

}  // namespace loopsift
