// SPDX-License-Identifier: MIT
#include "core/sifter/map_trial.hpp"

#include <chrono>

namespace loopsift {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::vector<Se3> fragment_poses(const PoseGraph& graph, const std::vector<Se3>& T_map_node) {
  std::vector<Se3> poses;
  poses.reserve(static_cast<std::size_t>(graph.fragment_count()));
  for (int f = 0; f < graph.fragment_count(); ++f) {
    poses.push_back(T_map_node[static_cast<std::size_t>(graph.first_node[static_cast<std::size_t>(f)])]);
  }
  return poses;
}

MapTrial::MapTrial(const PoseGraph& graph, MapScorer& scorer, ScoreKind kind, const SolveOptions& solve)
    : graph_(graph), T_odom_node_(graph.T_map_node), scorer_(&scorer), kind_(kind), solve_(solve) {
  graph_.loops.clear();
}

void MapTrial::score(double odometry_chi2, const ScoreLimits& limits, Span<float> view_values,
                     TrialResult* trial) {
  const auto start = std::chrono::steady_clock::now();
  const double b = scorer_->own_residual();
  trial->prior = kind_ == ScoreKind::kPosterior ? b * b * odometry_chi2 : 0.0;
  ScoreLimits map_limits = limits;
  map_limits.give_up_above -= trial->prior;
  const std::vector<Se3> poses = fragment_poses(graph_, trial->T_map_node);
  const MapScore map = scorer_->score(poses, kind_, map_limits, view_values);
  trial->misfit = map.value;
  trial->complete = map.complete;
  trial->score = trial->misfit + trial->prior;
  trial->score_ms = milliseconds_since(start);
}

TrialResult MapTrial::run(const std::vector<Edge>& frame_loops, const std::vector<Se3>& start,
                          const ScoreLimits& limits, Span<float> view_values) {
  const auto begin = std::chrono::steady_clock::now();
  graph_.loops = frame_loops;
  graph_.T_map_node = start;
  const SolveSummary summary = solve(solve_, &graph_);
  TrialResult trial;
  trial.solved = summary.converged;
  trial.T_map_node = graph_.T_map_node;
  trial.solve_ms = milliseconds_since(begin);
  if (trial.solved) score(summary.odometry_chi2, limits, view_values, &trial);
  return trial;
}

TrialResult MapTrial::as_it_is(const std::vector<Se3>& T_map_node, Span<float> view_values) {
  TrialResult trial;
  trial.solved = true;
  trial.T_map_node = T_map_node;
  score(0.0, {}, view_values, &trial);
  return trial;
}

TrialResult MapTrial::base(Span<float> view_values) { return as_it_is(T_odom_node_, view_values); }

void MapTrial::set_reference(const TrialResult& trial, bool restart) {
  if (restart) scorer_->clear_reference();
  const std::vector<Se3> poses = fragment_poses(graph_, trial.T_map_node);
  scorer_->set_reference(poses);
}

}  // namespace loopsift
