// SPDX-License-Identifier: MIT
// What may be asked of a run from outside (signals, commands). Lock-free flags: a signal handler may set
// them.
#pragma once
#include <atomic>

namespace loopsift {

struct RunControl {
  std::atomic<bool> stop{false};    ///< end now: results as they are, without a last look at the loops
  std::atomic<bool> finish{false};  ///< end as if the source had ended
  std::atomic<bool> paused{false};  ///< look at no frame
};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

}  // namespace loopsift
