// SPDX-License-Identifier: MIT
// The pose graph: keyframe nodes inside fragments, odometry edges between neighbours, accepted loops as frame
// loops. In: node poses and edges. Out: poses that minimise Σ ‖log(T̂_a_b⁻¹ T_map_a⁻¹ T_map_b)‖²_Λ, solved by
// Ceres (solve.cpp is the only file that sees it). Thread: back. Allocates.
#pragma once
#include <string>
#include <vector>

#include "core/base/ids.hpp"
#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/fragment/fragment.hpp"
#include "core/geometry/se3.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift {

/// A relative measurement between two nodes.
struct Edge {
  int a = 0, b = 0;                             ///< node indices
  Se3 T_a_b;                                    ///< measured
  Matrix6d information = Matrix6d::Identity();  ///< of log(T̂_a_b⁻¹ T_a_b), (t, ω) order
  LoopId loop;                                  ///< the loop it comes from; invalid: an odometry edge
};

/// A keyframe.
struct Node {
  FragmentId fragment;
  Se3 T_fragment_node;  ///< pose of the keyframe inside its fragment
  std::int64_t timestamp_ns = 0;
};

/// Nodes in order of time; the first node of a fragment is its reference (identity in the fragment).
struct PoseGraph {
  std::vector<Node> nodes;
  std::vector<Se3> T_map_node;  ///< current estimate, same size as nodes
  std::vector<Edge> odometry;
  std::vector<Edge> loops;      ///< frame loops of the accepted loops
  std::vector<int> first_node;  ///< of each fragment; size = fragments + 1, or empty
  [[nodiscard]] int fragment_count() const {
    return first_node.empty() ? 0 : static_cast<int>(first_node.size()) - 1;
  }
  [[nodiscard]] const Se3& T_map_fragment(FragmentId f) const {
    return T_map_node[static_cast<std::size_t>(first_node[f.index()])];
  }
};

/// Adds a closed fragment: up to `keyframes` nodes evenly spread over its frames, odometry edges between them
/// and from the last node before (none where tracking was lost in between), with the covariances of the
/// frame-to-frame motions summed. Every frame but the very first must carry its motion's information.
/// `previous` is null for the first fragment. T_map_node of the new nodes continues the current estimate of
/// the last node.
void append_fragment(const Fragment* previous, const Fragment& fragment, int keyframes, PoseGraph* graph);

/// Whether a way of edges, of the odometry or of loops, leads from node a to node b. Allocates.
[[nodiscard]] bool joined(const PoseGraph& graph, int a, int b);

/// For each fragment whether a way of edges leads from it to the first one. Allocates.
[[nodiscard]] std::vector<bool> anchored_fragments(const PoseGraph& graph);

/// Fragment loop → frame loops (paper): the reference node of i to every node of j and the reference of j to
/// every node of i, each composed from T_i_j and the poses inside the fragments. The loop's information is
/// carried to each edge's frame by the adjoint and divided by their number, so that together they claim what
/// the loop claims.
void append_frame_loops(const PoseGraph& graph, const Loop& loop, std::vector<Edge>* edges);

struct SolveOptions {
  int max_iterations = 50;
  double relative_cost_tolerance = 1e-6;
  double time_limit_s = 10.0;  ///< past it the solve counts as failed
  /// Whether running into max_iterations counts as success (for callers that change the weights every few
  /// steps); otherwise it counts as failed, as an estimate that nothing says is the minimum.
  bool accept_iteration_limit = false;
};

struct SolveSummary {
  bool converged = false;  ///< false: poses are as they were
  int iterations = 0;
  double initial_cost = 0;  ///< ½ Σ χ²
  double final_cost = 0;
  double odometry_chi2 = 0;  ///< Σ χ² of the odometry edges at the end
  double loop_chi2 = 0;      ///< Σ χ² of the loop edges at the end
  std::string message;       ///< why it did not converge
};

/// Optimises graph.T_map_node in place over graph.odometry and graph.loops; node 0 stays fixed (as does the
/// first node of each part that no edge joins to the rest). Levenberg–Marquardt, one thread, deterministic.
/// On failure (a malformed graph, NaN, no convergence within the limits, out of memory) the poses stay as
/// they were and the summary says why.
[[nodiscard]] SolveSummary solve(const SolveOptions& options, PoseGraph* graph);

/// χ² of one edge at given poses of its ends.
[[nodiscard]] double edge_chi2(const Edge& edge, const Se3& T_map_a, const Se3& T_map_b);

/// g2o text: VERTEX_SE3:QUAT and EDGE_SE3:QUAT, information converted between g2o's (t, q_xyz) and ours.
/// write also puts `PATH.times` beside it (node id, seconds). read gives one fragment per vertex, in order of
/// id, takes edges between consecutive vertices as odometry and all others as loops (numbered in order of
/// appearance), and times from `PATH.times` where that is there. Errors name file and line.
[[nodiscard]] Status write_g2o(const std::string& path, const PoseGraph& graph);
[[nodiscard]] Expected<PoseGraph> read_g2o(const std::string& path);

}  // namespace loopsift
