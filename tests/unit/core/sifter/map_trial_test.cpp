// SPDX-License-Identifier: MIT
#include "core/sifter/map_trial.hpp"

#include <gtest/gtest.h>

#include "tests/unit/core/sifter/sifting.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::Sifting;

std::vector<Edge> frame_loops(const PoseGraph& graph, const Loop& loop) {
  std::vector<Edge> edges;
  append_frame_loops(graph, loop, &edges);
  return edges;
}

// A trial with a solver of its own.
struct Trial {
  Trial(const Sifting& sifting, const PoseGraph& graph, ScoreKind kind, const SolveOptions& solve = {})
      : trial(*sifting.scorer, kind, solve, workspace) {
    trial.set_graph(graph);
  }
  Arena arena{1 << 20};
  SolverLimits limits{40, 240};
  SolverWorkspace workspace{&arena, limits};
  MapTrial trial;
};

TEST(MapTrial, ThePosteriorsPriorIsTheOdometrysChiSquaredInUnitsOfTheMap) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const PoseGraph graph = world.graph();
  for (const ScoreKind kind : {ScoreKind::kPlain, ScoreKind::kPosterior}) {
    Trial t(sifting, graph, kind);
    EXPECT_EQ(t.trial.base().prior, 0.0) << "the odometry agrees with itself";
    const TrialMap with = t.trial.run(frame_loops(graph, world.loop(0, 0, 6)), graph.T_map_node);
    ASSERT_TRUE(with.solved);
    const double b = sifting.scorer->own_residual();
    double chi2 = 0;
    for (const Edge& edge : graph.odometry)
      chi2 += edge_chi2(edge, with.T_map_node[static_cast<std::size_t>(edge.a)],
                        with.T_map_node[static_cast<std::size_t>(edge.b)]);
    EXPECT_GT(chi2, 0.1);
    EXPECT_NEAR(with.prior, kind == ScoreKind::kPosterior ? b * b * chi2 : 0.0, 1e-9 * chi2);
  }
}

TEST(MapTrial, AFailedSolveIsSaidToBeOne) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const PoseGraph graph = world.graph();
  Trial t(sifting, graph, ScoreKind::kPosterior);
  std::vector<Edge> edges = frame_loops(graph, world.loop(0, 0, 6));
  edges[0].b = 1000;
  EXPECT_FALSE(t.trial.run(edges, graph.T_map_node).solved);
  SolveOptions no_time;
  no_time.time_limit_s = 0;
  Trial hurried(sifting, graph, ScoreKind::kPosterior, no_time);
  EXPECT_FALSE(hurried.trial.run(frame_loops(graph, world.loop(0, 0, 6)), graph.T_map_node).solved);
}

// What does not fit the fast solver's memory goes to Ceres, with the same result.
TEST(MapTrial, AGraphTooLargeForTheFastSolverIsSolvedAllTheSame) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const PoseGraph graph = world.graph();
  Trial t(sifting, graph, ScoreKind::kPosterior);
  Arena arena{1 << 20};
  const SolverLimits too_small{4, 24};
  SolverWorkspace small(&arena, too_small);
  MapTrial by_ceres(*sifting.scorer, ScoreKind::kPosterior, {}, small);
  by_ceres.set_graph(graph);
  const std::vector<Edge> edges = frame_loops(graph, world.loop(0, 0, 6));
  const TrialMap a = t.trial.run(edges, graph.T_map_node), b = by_ceres.run(edges, graph.T_map_node);
  ASSERT_TRUE(a.solved && b.solved);
  for (std::size_t n = 0; n < a.T_map_node.size(); ++n)
    EXPECT_LT((a.T_map_node[n].inverse() * b.T_map_node[n]).log().norm(), 1e-4);
}

TEST(MapTrial, FragmentPosesAreThoseOfTheirFirstNodes) {
  const FragmentWorld world;
  const PoseGraph graph = world.graph(3);
  const std::vector<Se3> poses = fragment_poses(graph, graph.T_map_node);
  ASSERT_EQ(poses.size(), world.odometry().size());
  for (std::size_t f = 0; f < poses.size(); ++f)
    EXPECT_LT((poses[f].inverse() * world.odometry()[f]).log().norm(), 1e-9);
  EXPECT_TRUE(fragment_poses(PoseGraph{}, {}).empty());
}

}  // namespace
}  // namespace loopsift
