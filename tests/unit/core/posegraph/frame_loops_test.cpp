// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <set>

#include "core/posegraph/pose_graph.hpp"
#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

using test::RandomGraph;
using test::RandomGraphOptions;

TEST(FrameLoops, ConnectEachReferenceToEveryNodeOfTheOther) {
  RandomGraph world(RandomGraphOptions{});
  std::vector<Edge> edges;
  append_frame_loops(world.graph, world.true_loop(2, 9), &edges);
  std::set<std::pair<int, int>> ends;
  for (const Edge& edge : edges) ends.insert(std::minmax(edge.a, edge.b));
  const std::set<std::pair<int, int>> expected = {{6, 27}, {6, 28}, {6, 29}, {7, 27}, {8, 27}};
  EXPECT_EQ(ends, expected);
  EXPECT_EQ(edges.size(), expected.size());
}

TEST(FrameLoops, OfAPerfectLoopAgreeWithTheTruth) {
  RandomGraphOptions options;
  options.loop_sigma_m = options.loop_sigma_rad = 1e-12;
  RandomGraph world(options);
  std::vector<Edge> edges;
  const Loop loop = world.true_loop(1, 12);
  append_frame_loops(world.graph, loop, &edges);
  for (const Edge& edge : edges) {
    EXPECT_EQ(edge.loop, loop.id);
    const Se3 T_a_b = world.truth[static_cast<std::size_t>(edge.a)].inverse() *
                      world.truth[static_cast<std::size_t>(edge.b)];
    EXPECT_LT((edge.T_a_b.inverse() * T_a_b).log().norm(), 1e-9);
  }
}

// However far the fragments are from where the loop wants them, the edges together cost what the loop costs.
TEST(FrameLoops, ClaimTogetherWhatTheLoopClaims) {
  RandomGraph world(RandomGraphOptions{});
  Loop loop = world.true_loop(2, 9);
  Matrix6d A = Matrix6d::Random();
  loop.information = A * A.transpose() + Matrix6d::Identity();
  std::vector<Edge> edges;
  append_frame_loops(world.graph, loop, &edges);
  const Vector6d error = (Vector6d() << 0.02, -0.01, 0.03, 0.004, 0.002, -0.003).finished();
  PoseGraph moved = world.graph;  // both fragments rigid, j off by `error` from where the loop puts it
  const Se3 T_map_i = world.truth[6], T_map_j = T_map_i * loop.T_i_j * Se3::exp(error);
  for (std::size_t k = 0; k < 3; ++k) {
    moved.T_map_node[6 + k] = T_map_i * moved.nodes[6 + k].T_fragment_node;
    moved.T_map_node[27 + k] = T_map_j * moved.nodes[27 + k].T_fragment_node;
  }
  double chi2 = 0;
  for (const Edge& edge : edges)
    chi2 += edge_chi2(edge, moved.T_map_node[static_cast<std::size_t>(edge.a)],
                      moved.T_map_node[static_cast<std::size_t>(edge.b)]);
  EXPECT_NEAR(chi2, error.dot(loop.information * error), 1e-9 * chi2);
}

}  // namespace
}  // namespace loopsift
