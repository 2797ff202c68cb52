// SPDX-License-Identifier: MIT
// The pose graph's minimum once more, for the many test solves of the sifter: the same cost as solve(), by
// Levenberg–Marquardt on a block-sparse Cholesky factor, in memory that is carved once. In: a graph, best
// warm started near the answer. Out: its poses. Thread: one per workspace. Never allocates, but for the
// message of a failure.
//
// What solve() does with Ceres is the reference; both reach the same minimum when started in the same valley.
#pragma once
#include "core/base/arena.hpp"
#include "core/posegraph/block_cholesky.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {

/// Sizes of a workspace. max_blocks bounds the non-zero blocks under the diagonal of the factor: one per edge
/// of the chain, and what the loops add and fill in (10 loops over 180 nodes: about 400).
struct SolverLimits {
  int max_nodes = 600;
  int max_blocks = 12000;
};

/// All buffers of solve_fast. Holds nothing between two solves.
class SolverWorkspace {
 public:
  SolverWorkspace(Arena* arena, const SolverLimits& limits);
  [[nodiscard]] const SolverLimits& limits() const { return limits_; }
  /// Blocks under the diagonal in the last solve, fill included.
  [[nodiscard]] int block_count() const { return cholesky_.block_count(); }

 private:
  friend class FastSolver;
  SolverLimits limits_;
  BlockCholesky cholesky_;
  Span<int> unknown_;        // node → unknown, or −1 where it is fixed
  Span<Vector6d> gradient_;  // by unknown
  Span<Vector6d> step_;      // by unknown
  Span<Se3> start_, trial_;  // by node
};

/// As solve(), with the same options and the same meaning of the summary. Fails, too, on a graph larger than
/// the workspace (the message says which limit); solve() has no such limit.
[[nodiscard]] SolveSummary solve_fast(const SolveOptions& options, SolverWorkspace* workspace,
                                      PoseGraph* graph);

}  // namespace loopsift
