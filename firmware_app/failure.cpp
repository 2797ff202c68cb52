// SPDX-License-Identifier: MIT
#include "firmware_app/failure.hpp"

namespace loopsift {

ExitCode exit_code(const Failure& failure) {
  const bool is_usage = failure.error.code == ErrorCode::kUsage;
  switch (failure.phase) {
    case Phase::kSettings:
      return kExitUsage;
    case Phase::kMemoryPlan:
      return failure.error.code == ErrorCode::kCapacity ? kExitMemoryCap : kExitOther;
    case Phase::kSourceOpen:
      return is_usage ? kExitUsage : kExitSourceNotOpened;
    case Phase::kSourceRead:
      return kExitSourceLost;
    case Phase::kRun:
      return is_usage ? kExitUsage : kExitOther;
  }
  return kExitOther;
}

}  // namespace loopsift
