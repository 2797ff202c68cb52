// SPDX-License-Identifier: MIT
#include "core/pipeline/run_report.hpp"

#include <sys/resource.h>

#include <fstream>
#include <nlohmann/json.hpp>

namespace loopsift {
namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<std::int64_t>& value) { return value ? Json(*value) : Json(nullptr); }

/// The durations that 0, 5, … 100 % of the records do not exceed: what a picture of the distribution needs.
Json quantiles_json(const LatencyHistogram& h) {
  Json json = Json::array();
  for (int percent = 0; percent <= 100; percent += 5) json.push_back(h.percentile_ms(0.01 * percent));
  return json;
}

Json latency_json(const RunFigures& figures) {
  Json json = Json::object();
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    const LatencyHistogram& h = figures.latency[stage];
    json[kStageNames[stage]] = {{"p50", h.percentile_ms(0.5)},
                                {"p99", h.percentile_ms(0.99)},
                                {"max", h.max_ms()},
                                {"count", h.count()},
                                {"quantiles", quantiles_json(h)}};
  }
  return json;
}

Json memory_json(const RunFigures::Memory& memory) {
  return {{"budget_bytes", memory.budget_bytes},
          {"cap_bytes", memory.cap_bytes},
          {"peak_rss_bytes", memory.peak_rss_bytes},
          {"heap_calls_after_seal",
           {{"capture", or_null(memory.capture_heap_calls)},
            {"front", or_null(memory.front_heap_calls)},
            {"publish", or_null(memory.publish_heap_calls)}}},
          {"camera_library_heap_calls", or_null(memory.camera_library_heap_calls)},
          {"fence_peak_bytes", or_null(memory.fence_peak_bytes)},
          {"fence_refusals", or_null(memory.fence_refusals)}};
}

Json pools_json(const std::vector<PoolFigures>& pools) {
  Json json = Json::object();
  for (const PoolFigures& pool : pools)
    json[pool.name] = {
        {"capacity", pool.capacity}, {"high_water", pool.high_water}, {"refused", pool.refused}};
  return json;
}

}  // namespace

std::string run_report_json(const RunFigures& figures) {
  const auto& frames = figures.frames;
  const auto& loops = figures.loops;
  const Json json = {{"source", figures.source},
                     {"sequence_duration_s", figures.sequence_duration_s},
                     {"wall_s", figures.wall_s},
                     {"frames",
                      {{"received", frames.received},
                       {"dropped", frames.dropped},
                       {"tracked", frames.tracked},
                       {"lost", frames.lost}}},
                     {"latency_ms", latency_json(figures)},
                     {"loops",
                      {{"proposed", loops.proposed},
                       {"scored", loops.scored},
                       {"tested", loops.tested},
                       {"accepted", loops.accepted},
                       {"revoked", loops.revoked},
                       {"dropped", loops.dropped},
                       {"pending", loops.pending}}},
                     {"dmp",
                      {{"odometry", figures.dmp.odometry_m2},
                       {"final", figures.dmp.final_m2},
                       {"views", figures.dmp.views}}},
                     {"memory", memory_json(figures.memory)},
                     {"pools", pools_json(figures.pools)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // NaN becomes null
}

Status write_run_report(const std::string& path, const RunFigures& figures) {
  std::ofstream file(path);
  file << run_report_json(figures);
  file.flush();
  if (!file)
    return Error{ErrorCode::kIo, path + ": cannot be written; check that its folder exists and has room"};
  return {};
}

std::int64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;  // Linux counts KiB
}

}  // namespace loopsift
