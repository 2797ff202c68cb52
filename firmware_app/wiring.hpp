// SPDX-License-Identifier: MIT
// From settings to a run. In: settings. Out: a run from the source's first frame to the written
// results. Thread: main; starts and joins all others.
#pragma once
#include <optional>

#include "core/base/memory_budget.hpp"
#include "firmware_app/failure.hpp"
#include "firmware_app/progress.hpp"
#include "firmware_app/run_control.hpp"
#include "firmware_app/settings.hpp"

namespace loopsift {

/// What a run with these settings takes before its first frame; `budget` is filled also when it is over
/// the cap (a Failure). Opens the source to learn its image size; without one, 640×480 with colour is taken.
[[nodiscard]] std::optional<Failure> plan_memory(const Settings& settings, MemoryBudget* budget);

/// How a run ended. Everything found was written to settings.run.out, whatever the end.
struct RunEnd {
  std::optional<Failure> failure;
  /// A thread hangs and was left behind, with the memory that it uses: the process must end without running
  /// destructors (std::_Exit).
  bool thread_left_behind = false;
};

/// Runs until the source ends, is lost, or `control` says so.
[[nodiscard]] RunEnd run(const Settings& settings, RunControl& control, Progress* progress);

}  // namespace loopsift
