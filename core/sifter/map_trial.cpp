// SPDX-License-Identifier: MIT
#include "core/sifter/map_trial.hpp"

namespace loopsift {

std::vector<Se3> fragment_poses(const PoseGraph& graph, const std::vector<Se3>& T_map_node) {
  std::vector<Se3> poses;
  poses.reserve(static_cast<std::size_t>(graph.fragment_count()));
  for (int f = 0; f < graph.fragment_count(); ++f) {
    poses.push_back(T_map_node[static_cast<std::size_t>(graph.first_node[static_cast<std::size_t>(f)])]);
  }
  return poses;
}

MapTrial::MapTrial(const MapScorer& scorer, ScoreKind kind, const SolveOptions& solve,
                   SolverWorkspace& workspace)
    : scorer_(&scorer), workspace_(&workspace), kind_(kind), solve_(solve) {}

void MapTrial::set_graph(const PoseGraph& odometry) {
  graph_ = odometry;
  graph_.loops.clear();
  T_odom_node_ = odometry.T_map_node;
}

TrialMap MapTrial::run(const std::vector<Edge>& frame_loops, const std::vector<Se3>& start) {
  graph_.loops = frame_loops;
  graph_.T_map_node = start;
  SolveSummary summary = solve_fast(solve_, workspace_, &graph_);
  if (!summary.converged) summary = solve(solve_, &graph_);
  TrialMap map = as_it_is(graph_.T_map_node);
  map.solved = summary.converged;
  const double b = scorer_->own_residual();
  if (kind_ == ScoreKind::kPosterior) map.prior = b * b * summary.odometry_chi2;
  return map;
}

TrialMap MapTrial::as_it_is(const std::vector<Se3>& T_map_node) const {
  return {true, T_map_node, fragment_poses(graph_, T_map_node), 0.0};
}

}  // namespace loopsift
