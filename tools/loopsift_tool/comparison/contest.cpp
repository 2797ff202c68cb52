// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/comparison/contest.hpp"

#include "core/base/steady_time.hpp"
#include "tools/loopsift_tool/filters/filter.hpp"

namespace loopsift::tool {
namespace {

using RunFilter = Expected<FilterResult> (*)(const PoseGraph&, Span<const Loop>);

Outcome run_published(RunFilter filter, const ContestInput& input, const std::vector<Loop>& loops) {
  const std::int64_t begin = steady_now_ns();
  const Expected<FilterResult> result = filter(input.odometry, loops);
  Outcome outcome;
  outcome.wall_s = 1e-9 * static_cast<double>(steady_now_ns() - begin);
  outcome.T_map_node = result.ok() ? result->graph.T_map_node : input.odometry.T_map_node;
  if (!result.ok()) {
    outcome.failure = result.error().message;
    return outcome;
  }
  for (const LoopId id : result->accepted) outcome.accepted.insert(id.value);
  return outcome;
}

Outcome run_on_true_loops(const ContestInput& input) {
  std::vector<Loop> loops;
  for (const Loop& loop : input.loops)
    if (input.true_ids.count(loop.id.value) != 0) loops.push_back(loop);
  return run_published(run_all, input, loops);
}

// The time is that of sifting: the fragments have been scored before, as they are onboard when a loop comes.
Outcome run_ours(ScoreKind score, const ContestInput& input) {
  const std::unique_ptr<DetachedBackEnd> back_end = input.map->make_back_end(score, input.odometry_factor);
  const std::int64_t begin = steady_now_ns();
  (*back_end)->add_loops(input.loops);
  (*back_end)->finish();
  Outcome outcome;
  outcome.wall_s = 1e-9 * static_cast<double>(steady_now_ns() - begin);
  outcome.T_map_node = (*back_end)->sifter().T_map_node();
  for (const Loop& loop : (*back_end)->sifter().accepted()) outcome.accepted.insert(loop.id.value);
  return outcome;
}

std::vector<Contestant> make_contestants() {
  std::vector<Contestant> all;
  for (const NamedFilter& filter : published_filters())
    all.push_back({filter.name, [run = filter.run](const ContestInput& input) {
                     return run_published(run, input, input.loops);
                   }});
  all.push_back(
      {"loopsift", [](const ContestInput& input) { return run_ours(ScoreKind::kPosterior, input); }});
  all.push_back(
      {"loopsift_plain", [](const ContestInput& input) { return run_ours(ScoreKind::kPlain, input); }});
  all.push_back({"all true loops", run_on_true_loops});
  return all;
}

std::optional<double> fraction(std::size_t part, std::size_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

const std::vector<Contestant>& contestants() {
  static const std::vector<Contestant> kAll = make_contestants();
  return kAll;
}

std::vector<PosePair> pose_pairs(const ContestInput& input, const Truth& truth, const Outcome& outcome) {
  const Trajectory corrected = corrected_trajectory(input.map->frames(), input.odometry, outcome.T_map_node);
  std::vector<PosePair> pairs;
  std::size_t k = 0;
  for (const Fragment& fragment : input.map->fragments()) {
    for (const FragmentFrame& frame : fragment.frames) {
      const StampedPose& pose = corrected.poses[k++];
      Se3 T_gt_camera;
      if (truth.pose(frame, &T_gt_camera)) pairs.push_back({pose.time_s, T_gt_camera, pose.T_world_camera});
    }
  }
  return pairs;
}

Figures judge(const ContestInput& input, const Truth& truth, const Outcome& outcome) {
  std::size_t correct = 0;
  for (const int id : outcome.accepted) correct += input.true_ids.count(id);
  Figures figures;
  figures.accepted = outcome.accepted.size();
  figures.precision = fraction(correct, outcome.accepted.size());
  figures.recall = fraction(correct, input.true_ids.size());
  const std::vector<PosePair> pairs = pose_pairs(input, truth, outcome);
  if (pairs.size() >= 3) figures.ate_rmse_m = trajectory_error(pairs).ate_rmse_m;
  return figures;
}

}  // namespace loopsift::tool
