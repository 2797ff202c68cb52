// SPDX-License-Identifier: MIT
#include "core/posegraph/node_covariance.hpp"

#include <gtest/gtest.h>

#include "tests/support/in_arena.hpp"
#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

struct Room {
  explicit Room(Arena& arena) : covariance(&arena, 200, 2000) {}
  NodeCovariance covariance;
};

Matrix6d covariance_of(const PoseGraph& graph, int node) {
  const test::InArena<Room> room;
  Matrix6d covariance = Matrix6d::Zero();
  EXPECT_TRUE(room->covariance.compute(graph, node, &covariance));
  return covariance;
}

/// A straight chain at its minimum, each motion known as well as the others.
PoseGraph chain(int nodes) {
  PoseGraph graph;
  Matrix6d information = Matrix6d::Identity() * 1e4;
  information(0, 0) = 400;
  for (int n = 0; n < nodes; ++n) {
    graph.nodes.push_back({FragmentId{n}, Se3(), 0});
    graph.T_map_node.push_back(Se3::exp((Vector6d() << 0.5, 0.1, 0, 0, 0, 0.3).finished() * n));
    if (n > 0)
      graph.odometry.push_back(
          {n - 1, n, graph.T_map_node[graph.T_map_node.size() - 2].inverse() * graph.T_map_node.back(),
           information, LoopId{}});
  }
  return graph;
}

// On a chain the covariances of the motions add up, each carried to the end by the adjoint.
TEST(NodeCovariance, OnAChainItIsTheSumOfTheMotions) {
  const PoseGraph graph = chain(6);
  Matrix6d expected = Matrix6d::Zero();
  for (const Edge& edge : graph.odometry) {
    const Matrix6d back = edge.T_a_b.inverse().adjoint();
    expected = back * expected * back.transpose() + Matrix6d(edge.information.inverse());
  }
  EXPECT_LT((covariance_of(graph, 5) - expected).norm(), 1e-9 * expected.norm());
  EXPECT_EQ(covariance_of(graph, 0).norm(), 0) << "the first node is where it is";
}

TEST(NodeCovariance, ALoopMakesItSmaller) {
  PoseGraph graph = chain(12);
  const Matrix6d before = covariance_of(graph, 11);
  graph.loops.push_back(
      {0, 11, graph.T_map_node[0].inverse() * graph.T_map_node[11], Matrix6d::Identity() * 1e4, LoopId{0}});
  const Matrix6d after = covariance_of(graph, 11);
  // Two independent words on the same pose: informations add.
  const Matrix6d expected = (before.inverse() + Matrix6d::Identity() * 1e4).inverse();
  EXPECT_LT((after - expected).norm(), 1e-6 * expected.norm());
  EXPECT_LT(after.trace(), before.trace());
}

TEST(NodeCovariance, IsNotKnownAcrossAGap) {
  PoseGraph graph = chain(8);
  graph.odometry.erase(graph.odometry.begin() + 3);  // 3 → 4
  const test::InArena<Room> room;
  Matrix6d covariance;
  EXPECT_FALSE(room->covariance.compute(graph, 7, &covariance));
  EXPECT_TRUE(room->covariance.compute(graph, 3, &covariance)) << "what lies before the gap is";
}

TEST(NodeCovariance, RefusesWhatIsLargerThanItsRoom) {
  const test::InArena<Room> room;
  Matrix6d covariance;
  EXPECT_FALSE(room->covariance.compute(chain(201), 200, &covariance));
  EXPECT_FALSE(room->covariance.compute(chain(3), 3, &covariance));
  EXPECT_FALSE(room->covariance.compute(PoseGraph(), 0, &covariance));
}

}  // namespace
}  // namespace loopsift
