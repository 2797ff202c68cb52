// SPDX-License-Identifier: MIT
// One trial map: the odometry graph with a set of loops, optimised, fragments moved rigidly, scored.
// This is `r(fuseModel(optimize(G, O)), Z)` of Algorithm 1 (Zhang & Chen, loop sifting). Thread: back.
// Allocates.
//
// The posterior's score is −2b² · log(likelihood × prior) but for constants: Σ_t 2b · mean |D̂_t − D_t| + b²
// χ²(odometry), with b the residual that the map shows about itself. The plain score is the DMP alone.
#pragma once
#include <limits>
#include <vector>

#include "core/posegraph/pose_graph.hpp"
#include "core/posterior/map_scorer.hpp"

namespace loopsift {

/// What a trial came to. Lower is better (the paper's r is −score).
struct TrialResult {
  bool solved = false;    ///< false: the solve failed; nothing else holds
  bool complete = false;  ///< false: given up above the limit; score is a lower bound
  double score = 0;       ///< m²; misfit + prior
  double misfit = 0;      ///< the depth's part
  double prior = 0;       ///< the odometry's part; 0 for the plain score
  std::vector<Se3> T_map_node;
  double solve_ms = 0, score_ms = 0;
};

class MapTrial {
 public:
  /// graph holds the odometry's poses and edges (its loops are ignored); scorer has the same fragments and
  /// outlives this.
  MapTrial(const PoseGraph& graph, MapScorer& scorer, ScoreKind kind, const SolveOptions& solve);

  /// Optimises the odometry graph with these frame loops, from `start`, and scores the map. view_values as in
  /// MapScorer::score.
  [[nodiscard]] TrialResult run(const std::vector<Edge>& frame_loops, const std::vector<Se3>& start,
                                const ScoreLimits& limits = {}, Span<float> view_values = {});
  /// The map at these poses as it is, unsolved: what is left when a solve fails. Its prior is 0.
  [[nodiscard]] TrialResult as_it_is(const std::vector<Se3>& T_map_node, Span<float> view_values = {});
  /// The odometry's map, with no loop.
  [[nodiscard]] TrialResult base(Span<float> view_values = {});
  /// Makes a trial's map the reference for support; restart: forgets all support before.
  void set_reference(const TrialResult& trial, bool restart);
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const MapScorer& scorer() const { return *scorer_; }

 private:
  void score(double odometry_chi2, const ScoreLimits& limits, Span<float> view_values, TrialResult* trial);

  PoseGraph graph_;
  std::vector<Se3> T_odom_node_;
  MapScorer* scorer_;
  ScoreKind kind_;
  SolveOptions solve_;
};

/// Pose of each fragment from the poses of all nodes.
[[nodiscard]] std::vector<Se3> fragment_poses(const PoseGraph& graph, const std::vector<Se3>& T_map_node);

}  // namespace loopsift
