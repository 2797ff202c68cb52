// SPDX-License-Identifier: MIT
#include "firmware_app/run_results.hpp"

#include <spdlog/spdlog.h>

#include <optional>
#include <vector>

#include "core/base/heap_watch.hpp"
#include "core/pipeline/results.hpp"
#include "firmware_app/supervisor.hpp"

namespace loopsift {

void collect(const Parts& parts, Shared* shared) {
  RunFigures* figures = &shared->figures;
  const FrameQueueCounts counts = parts.queue.counts();
  const FrontStatus& front = parts.front.status();
  figures->frames = {counts.received + counts.bad, counts.dropped + counts.bad, front.tracked, front.lost};
  (*figures)[Stage::kProposal] = parts.back_end.proposal_times();
  (*figures)[Stage::kLoopSolve] = parts.back_end.sifter().solve_times();
  (*figures)[Stage::kLoopScore] = parts.back_end.sifter().score_times();
  (*figures)[Stage::kLoopTest] = parts.back_end.sifter().test_times();
  (*figures)[Stage::kCorrection] = parts.back_worker.correction_times();
  figures->pools = parts.publisher.pools();
  for (const std::vector<PoolFigures>& more :
       {store_pools(parts.store), parts.front.pools(), parts.back_worker.pools()})
    figures->pools.insert(figures->pools.end(), more.begin(), more.end());
  const ActiveSurfels& active = parts.front_end.builder().active();
  figures->pools.push_back({"fragment/active surfels", static_cast<std::int64_t>(active.capacity()),
                            static_cast<std::int64_t>(active.high_water()),
                            static_cast<std::int64_t>(active.refused())});
  const auto counted = [](std::int64_t calls) { return calls < 0 ? std::nullopt : std::optional(calls); };
  figures->memory.capture_heap_calls = counted((*shared)[ThreadRole::kCapture].heap_calls());
  figures->memory.front_heap_calls = counted((*shared)[ThreadRole::kFront].heap_calls());
  figures->memory.publish_heap_calls = counted((*shared)[ThreadRole::kPublish].heap_calls());
  figures->memory.camera_library_heap_calls = counted((*shared)[ThreadRole::kCapture].library_heap_calls());
  if (!heap_is_watched()) return;
  figures->memory.fence_peak_bytes = parts.back_worker.heap_figures().peak_bytes;
  figures->memory.fence_refusals = parts.back_worker.heap_figures().refusals;
}

void collect_back(const Parts& parts, RunFigures* figures) {
  const Sifter& sifter = parts.back_end.sifter();
  figures->loops.proposed = static_cast<std::int64_t>(sifter.records().size()) + sifter.dropped();
  figures->loops.dropped = sifter.dropped();
  figures->loops.pending = sifter.pending();
  figures->loops.scored = sifter.counts().scored;
  figures->loops.tested = sifter.counts().tested;
  figures->loops.accepted = static_cast<std::int64_t>(sifter.accepted().size());
  figures->loops.revoked = sifter.counts().revoked;
  figures->dmp.views = parts.back_end.scorer().view_count();
}

void score(const BackEnd& back_end, RunFigures::Dmp* dmp) {
  dmp->odometry_m2 = back_end.dmp_odometry();
  dmp->final_m2 = back_end.dmp_final();
}

Status write_files(const std::string& out, const Parts& parts, bool with_back_end) {
  const FrontLoop& front = parts.front;
  if (with_back_end) return write_results(out, parts.back_end, front.poses(), parts.store.fragments());
  spdlog::warn("the back thread did not end: the results are the odometry's, moved by the last correction");
  return write_front_results(out, front.T_map_odom(), front.poses(), parts.store.fragments());
}

}  // namespace loopsift
