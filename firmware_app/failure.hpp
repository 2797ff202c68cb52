// SPDX-License-Identifier: MIT
// Why the onboard program ends early, and with which exit code.
#pragma once
#include "core/base/result.hpp"

namespace loopsift {

/// The program's exit codes; users' scripts and service files rely on them.
enum ExitCode : int {
  kExitDone = 0,
  kExitOther = 1,
  kExitUsage = 2,            ///< bad usage or settings
  kExitSourceNotOpened = 3,  ///< the source could not be opened
  kExitMemoryCap = 4,        ///< the memory budget is over memory.cap_mib
  kExitSourceLost = 5,       ///< the source was lost beyond the retry limit
};

/// What the program was doing.
enum class Phase { kSettings, kMemoryPlan, kSourceOpen, kSourceRead, kRun };

struct Failure {
  Phase phase = Phase::kRun;
  Error error;
};

/// The one mapping from failures to exit codes.
[[nodiscard]] ExitCode exit_code(const Failure& failure);

}  // namespace loopsift
