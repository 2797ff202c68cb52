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

TEST(MapTrial, PosteriorIsMisfitAndPriorThePlainScoreMisfitAlone) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const PoseGraph graph = world.graph();
  for (const ScoreKind kind : {ScoreKind::kPlain, ScoreKind::kPosterior}) {
    MapTrial trial(graph, *sifting.scorer, kind, {});
    const TrialResult base = trial.base();
    EXPECT_TRUE(base.solved && base.complete);
    EXPECT_EQ(base.prior, 0.0) << "the odometry agrees with itself";
    const TrialResult with = trial.run(frame_loops(graph, world.loop(0, 0, 6)), graph.T_map_node);
    ASSERT_TRUE(with.solved && with.complete);
    EXPECT_EQ(with.score, with.misfit + with.prior);
    const double b = sifting.scorer->own_residual();
    double chi2 = 0;
    for (const Edge& edge : graph.odometry)
      chi2 += edge_chi2(edge, with.T_map_node[static_cast<std::size_t>(edge.a)],
                        with.T_map_node[static_cast<std::size_t>(edge.b)]);
    EXPECT_GT(chi2, 0.1);
    EXPECT_NEAR(with.prior, kind == ScoreKind::kPosterior ? b * b * chi2 : 0.0, 1e-9 * chi2);
  }
}

TEST(MapTrial, GivesUpAboveTheLimitPriorIncluded) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const PoseGraph graph = world.graph();
  MapTrial trial(graph, *sifting.scorer, ScoreKind::kPosterior, {});
  const std::vector<Edge> edges = frame_loops(graph, world.loop(0, 0, 6));
  const double full = trial.run(edges, graph.T_map_node).score;
  for (const double part : {0.01, 0.5, 0.999, 1.001}) {
    ScoreLimits limits;
    limits.give_up_above = part * full;
    const TrialResult result = trial.run(edges, graph.T_map_node, limits);
    EXPECT_EQ(result.complete, part > 1.0);
    EXPECT_LE(result.score, full * (1 + 1e-6));
    EXPECT_GE(result.score, std::min(limits.give_up_above, full) * (1 - 1e-9));
  }
}

TEST(MapTrial, AFailedSolveIsSaidToBeOne) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const PoseGraph graph = world.graph();
  MapTrial trial(graph, *sifting.scorer, ScoreKind::kPosterior, {});
  std::vector<Edge> edges = frame_loops(graph, world.loop(0, 0, 6));
  edges[0].b = 1000;
  EXPECT_FALSE(trial.run(edges, graph.T_map_node).solved);
  SolveOptions no_time;
  no_time.time_limit_s = 0;
  MapTrial hurried(graph, *sifting.scorer, ScoreKind::kPosterior, no_time);
  EXPECT_FALSE(hurried.run(frame_loops(graph, world.loop(0, 0, 6)), graph.T_map_node).solved);
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
