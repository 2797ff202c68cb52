// SPDX-License-Identifier: MIT
#include "core/posegraph/chain_drift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace loopsift {
namespace {

// Fragments of two nodes, a metre from one to the next; each edge knows positions to 3 mm and angles to 4
// mrad.
PoseGraph chain(int fragments) {
  PoseGraph graph;
  Vector6d variance;
  variance << 9e-6, 9e-6, 9e-6, 16e-6, 16e-6, 16e-6;
  for (int n = 0; n < 2 * fragments; ++n) {
    if (n % 2 == 0) graph.first_node.push_back(n);
    graph.nodes.push_back({FragmentId{n / 2}, Se3(), n});
    graph.T_map_node.push_back(Se3(Eigen::Matrix3d::Identity(), {0.5 * n, 0, 0}));
    if (n == 0) continue;
    Edge edge;
    edge.a = n - 1, edge.b = n;
    edge.information = variance.cwiseInverse().asDiagonal();
    graph.odometry.push_back(edge);
  }
  graph.first_node.push_back(2 * fragments);
  return graph;
}

TEST(DriftToNewest, SumsTheChainAndTurnsAnglesIntoDistance) {
  const std::vector<float> drift = drift_to_newest(chain(5));
  ASSERT_EQ(drift.size(), 5U);
  EXPECT_EQ(drift[4], 0.0F);
  for (int f = 0; f < 4; ++f) {
    const double distance = 4 - f, edges = 2 * distance;
    EXPECT_NEAR(drift[static_cast<std::size_t>(f)], std::sqrt(edges * (9e-6 + 16e-6 * distance * distance)),
                1e-6)
        << f;
  }
}

TEST(DriftToNewest, IsAMetreBeyondABreakOrWhereNothingIsKnown) {
  PoseGraph graph = chain(6);
  graph.odometry.erase(graph.odometry.begin() + 5);  // into fragment 3
  std::vector<float> drift = drift_to_newest(graph);
  EXPECT_LT(drift[3], 0.1F);
  for (int f = 0; f < 3; ++f) EXPECT_EQ(drift[static_cast<std::size_t>(f)], 1.0F) << f;

  graph = chain(3);
  graph.odometry[2].information.setConstant(std::numeric_limits<double>::quiet_NaN());
  drift = drift_to_newest(graph);
  EXPECT_EQ(drift[0], 1.0F);
  EXPECT_EQ(drift[2], 0.0F);
}

TEST(DriftToNewest, OfNoMapIsNothing) { EXPECT_TRUE(drift_to_newest({}).empty()); }

}  // namespace
}  // namespace loopsift
