// SPDX-License-Identifier: MIT
// One trial map: the odometry graph with a set of loops, optimised, fragments moved rigidly.
// This is `fuseModel(optimize(G, O), Z)` of Algorithm 1 (Zhang & Chen, loop sifting), and what of its score
// does not depend on the depth. Thread: back. Allocates the poses it returns.
//
// The posterior's score is −2b² · log(likelihood × prior) but for constants: Σ_t 2b · mean |D̂_t − D_t| + b²
// χ²(odometry), with b the residual that the map shows about itself. The plain score is the DMP alone.
#pragma once
#include <vector>

#include "core/posegraph/fast_solver.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "core/posterior/map_scorer.hpp"

namespace loopsift {

/// What loops are judged by.
enum class ScoreKind {
  kPlain,      ///< the paper's: DMP
  kPosterior,  ///< likelihood (core/posterior/map_likelihood.hpp) and the odometry's prior
};

/// An optimised map. Scores in m², lower is better (the paper's r is −score).
struct TrialMap {
  bool solved = false;  ///< false: the solve failed; the poses are those it started from
  std::vector<Se3> T_map_node;
  std::vector<Se3> T_map_fragment;
  double prior = 0;  ///< the odometry's part of the score; 0 for the plain score
};

class MapTrial {
 public:
  /// Scorer and workspace outlive this.
  MapTrial(const MapScorer& scorer, ScoreKind kind, const SolveOptions& solve, SolverWorkspace& workspace);

  /// The odometry's poses and edges, of the fragments that the scorer holds; its loops are ignored.
  void set_graph(const PoseGraph& odometry);
  /// Optimises the odometry graph with these frame loops, from `start`. A graph too large for the workspace,
  /// and one whose fast solve fails, goes to Ceres.
  [[nodiscard]] TrialMap run(const std::vector<Edge>& frame_loops, const std::vector<Se3>& start);
  /// The map at these poses as it is, unsolved. Its prior is 0.
  [[nodiscard]] TrialMap as_it_is(const std::vector<Se3>& T_map_node) const;
  /// The odometry's map, with no loop.
  [[nodiscard]] TrialMap base() const { return as_it_is(T_odom_node_); }
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const MapScorer& scorer() const { return *scorer_; }
  [[nodiscard]] ScoreKind kind() const { return kind_; }

 private:
  PoseGraph graph_;
  std::vector<Se3> T_odom_node_;
  const MapScorer* scorer_;
  SolverWorkspace* workspace_;
  ScoreKind kind_;
  SolveOptions solve_;
};

/// Pose of each fragment from the poses of all nodes.
[[nodiscard]] std::vector<Se3> fragment_poses(const PoseGraph& graph, const std::vector<Se3>& T_map_node);

}  // namespace loopsift
