// SPDX-License-Identifier: MIT
#include "firmware_app/memory_plan.hpp"

#include "firmware_app/realtime.hpp"
#include "firmware_app/run_parts.hpp"

namespace loopsift {
namespace {

/// What is there beside the arena: the program with what its source and libraries took so far, what a run
/// will still load of the libraries' code (measured: 0.3 MiB) and take for itself, stacks, the heap of the
/// back thread.
void add_process_rows(const Settings& settings, MemoryBudget* budget) {
  constexpr std::size_t kStillToCome = mebibytes(3) / 2;
  const auto so_far = static_cast<std::size_t>(resident_bytes());
  budget->add("process/program, source", 1,
              (so_far + kStillToCome + mebibytes(1) - 1) / mebibytes(1) * mebibytes(1));
  budget->add("process/stacks", kThreadCount, kThreadCount * kStackBytes / 4);
  budget->add("back/heap", 1, heap_region_bytes(settings));
}

}  // namespace

std::size_t heap_region_bytes(const Settings& settings) {
  return mebibytes(settings.memory.back_heap_mib) / 4 * 5;
}

std::optional<Failure> measure(const Settings& settings, SupervisedSource& source, MemoryPlan* plan) {
  if (const Status fits = check_views(settings, source.info().camera); !fits.ok())
    return Failure{Phase::kSettings, fits.error()};
  Arena measuring;
  Shared shared;
  const Parts parts(settings, source, nullptr, shared, measuring);
  plan->budget = measuring.budget();
  plan->arena_bytes = plan->budget.total_bytes();
  add_process_rows(settings, &plan->budget);
  const std::size_t cap_bytes = mebibytes(settings.memory.cap_mib);
  if (plan->budget.total_bytes() <= cap_bytes) return std::nullopt;
  return Failure{Phase::kMemoryPlan,
                 {ErrorCode::kCapacity,
                  "the memory budget is over memory.cap_mib; raise it, or make the largest "
                  "of these smaller:\n" +
                      plan->budget.to_text(cap_bytes)}};
}

}  // namespace loopsift
