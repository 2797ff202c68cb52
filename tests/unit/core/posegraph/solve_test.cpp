// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "core/posegraph/pose_graph.hpp"
#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

using test::RandomGraph;
using test::RandomGraphOptions;
using ::testing::HasSubstr;

constexpr double kQuarterTurn = 1.5707963267948966;

// Four sides of one metre with a quarter turn each: the loop closes exactly.
PoseGraph square_graph() {
  PoseGraph graph;
  const Se3 side(so3_exp({0, 0, kQuarterTurn}), {1, 0, 0});
  for (int n = 0; n < 4; ++n) {
    graph.nodes.push_back({FragmentId{n}, Se3(), n});
    graph.first_node.push_back(n);
    graph.T_map_node.push_back(n == 0 ? Se3() : graph.T_map_node.back() * side);
    if (n > 0) graph.odometry.push_back({n - 1, n, side, Matrix6d::Identity(), LoopId{}});
  }
  graph.first_node.push_back(4);
  graph.loops.push_back({3, 0, side, Matrix6d::Identity(), LoopId{0}});
  return graph;
}

TEST(Solve, BringsASquareBackFromWrongPoses) {
  PoseGraph graph = square_graph();
  const std::vector<Se3> expected = graph.T_map_node;
  for (std::size_t n = 1; n < 4; ++n)
    graph.T_map_node[n] = graph.T_map_node[n] * Se3::exp(Vector6d::Constant(0.1 * static_cast<double>(n)));
  SolveOptions options;
  options.relative_cost_tolerance = 1e-14;
  const SolveSummary summary = solve(options, &graph);
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_GT(summary.initial_cost, 0.01);
  EXPECT_LT(summary.final_cost, 1e-12);
  EXPECT_GT(summary.iterations, 0);
  for (std::size_t n = 0; n < 4; ++n)
    EXPECT_LT((expected[n].inverse() * graph.T_map_node[n]).log().norm(), 1e-6);
}

// A closure that asks for 0.1 m along the way spreads evenly over equal edges on a straight line.
TEST(Solve, SpreadsAClosureEvenly) {
  PoseGraph graph;
  for (int n = 0; n < 5; ++n) {
    graph.nodes.push_back({FragmentId{n}, Se3(), n});
    graph.first_node.push_back(n);
    graph.T_map_node.emplace_back(Eigen::Matrix3d::Identity(), Eigen::Vector3d(n, 0, 0));
    if (n > 0)
      graph.odometry.push_back(
          {n - 1, n, Se3(Eigen::Matrix3d::Identity(), {1, 0, 0}), Matrix6d::Identity(), LoopId{}});
  }
  graph.first_node.push_back(5);
  graph.loops.push_back(
      {0, 4, Se3(Eigen::Matrix3d::Identity(), {4.1, 0, 0}), Matrix6d::Identity(), LoopId{0}});
  SolveOptions options;
  options.relative_cost_tolerance = 1e-14;
  const SolveSummary summary = solve(options, &graph);
  ASSERT_TRUE(summary.converged) << summary.message;
  for (int n = 0; n < 5; ++n)
    EXPECT_NEAR(graph.T_map_node[static_cast<std::size_t>(n)].translation().x(), n * 1.02, 1e-9);
  EXPECT_NEAR(summary.odometry_chi2, 4 * 0.02 * 0.02, 1e-10);
  EXPECT_NEAR(summary.loop_chi2, 0.02 * 0.02, 1e-10);
  EXPECT_NEAR(2.0 * summary.final_cost, summary.odometry_chi2 + summary.loop_chi2, 1e-12);
}

TEST(Solve, TrueLoopsReduceTheErrorOfADriftingRing) {
  RandomGraph world(RandomGraphOptions{});
  const double before = world.rmse_m(world.graph);
  for (const Loop& loop : world.true_loops(6)) append_frame_loops(world.graph, loop, &world.graph.loops);
  const SolveSummary summary = solve(SolveOptions{}, &world.graph);
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(world.rmse_m(world.graph), 0.6 * before);
}

TEST(Solve, GivesTheSameBitsTwice) {
  RandomGraph world(RandomGraphOptions{});
  for (const Loop& loop : world.true_loops(6)) append_frame_loops(world.graph, loop, &world.graph.loops);
  PoseGraph first = world.graph, second = world.graph;
  ASSERT_TRUE(solve(SolveOptions{}, &first).converged);
  ASSERT_TRUE(solve(SolveOptions{}, &second).converged);
  for (std::size_t n = 0; n < first.T_map_node.size(); ++n)
    EXPECT_EQ((first.T_map_node[n].matrix() - second.T_map_node[n].matrix()).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Solve, KeepsTheFirstNodeOfEveryPartFixed) {
  PoseGraph graph = square_graph();
  const int offset = 4;
  PoseGraph other = square_graph();  // a second square that no edge joins to the first, elsewhere
  const Se3 T_elsewhere(so3_exp({0.3, 0.2, 0.1}), {10, 5, 2});
  for (int n = 0; n < 4; ++n) {
    graph.nodes.push_back({FragmentId{offset + n}, Se3(), offset + n});
    graph.T_map_node.push_back(T_elsewhere * other.T_map_node[static_cast<std::size_t>(n)]);
    graph.first_node.push_back(offset + n + 1);
  }
  for (Edge edge : other.odometry) {
    edge.a += offset, edge.b += offset;
    graph.odometry.push_back(edge);
  }
  graph.T_map_node[2] = graph.T_map_node[2] * Se3::exp(Vector6d::Constant(0.1));
  graph.T_map_node[6] = graph.T_map_node[6] * Se3::exp(Vector6d::Constant(0.1));
  const std::vector<Se3> before = graph.T_map_node;
  const SolveSummary summary = solve(SolveOptions{}, &graph);
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(summary.final_cost, 1e-6);
  EXPECT_EQ(graph.T_map_node[0].matrix(), before[0].matrix());
  EXPECT_EQ(graph.T_map_node[4].matrix(), before[4].matrix());
}

TEST(Solve, OfAGraphWithoutEdgesChangesNothing) {
  PoseGraph graph = square_graph();
  graph.odometry.clear();
  graph.loops.clear();
  EXPECT_TRUE(solve(SolveOptions{}, &graph).converged);
}

// Runs a solve that has to fail, and returns why after checking that no pose moved.
std::string failure_of(const SolveOptions& options, PoseGraph graph) {
  const std::vector<Se3> before = graph.T_map_node;
  const SolveSummary summary = solve(options, &graph);
  EXPECT_FALSE(summary.converged);
  EXPECT_EQ(before.size(), graph.T_map_node.size());
  for (std::size_t n = 0; n < before.size(); ++n)
    EXPECT_EQ(std::memcmp(&before[n], &graph.T_map_node[n], sizeof(Se3)), 0) << "pose " << n << " moved";
  return summary.message;
}

TEST(Solve, NamesTheNodeWithoutAPose) {
  PoseGraph graph = square_graph();
  graph.T_map_node[2] = Se3(Eigen::Matrix3d::Identity(), {0, std::numeric_limits<double>::quiet_NaN(), 0});
  EXPECT_THAT(failure_of(SolveOptions{}, graph), HasSubstr("node 2"));
}

TEST(Solve, NamesTheEdgeThatIsMalformed) {
  PoseGraph graph = square_graph();
  graph.odometry[1].information(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(failure_of(SolveOptions{}, graph), HasSubstr("odometry edge 1 (1 → 2)"));
  graph = square_graph();
  graph.loops[0].b = 4;
  EXPECT_THAT(failure_of(SolveOptions{}, graph), HasSubstr("loop edge 0 (3 → 4)"));
  graph = square_graph();
  graph.loops[0].information *= -1.0;
  EXPECT_THAT(failure_of(SolveOptions{}, graph), HasSubstr("positive semi-definite"));
}

TEST(Solve, KeepsThePosesWhenTimeOrIterationsRunOut) {
  RandomGraph world(RandomGraphOptions{});
  for (const Loop& loop : world.true_loops(6)) append_frame_loops(world.graph, loop, &world.graph.loops);
  SolveOptions options;
  options.time_limit_s = 0.0;
  EXPECT_THAT(failure_of(options, world.graph), HasSubstr("limit of"));
  options = SolveOptions{};
  options.max_iterations = 1;
  options.relative_cost_tolerance = 1e-15;
  EXPECT_THAT(failure_of(options, world.graph), HasSubstr("1 iterations"));
  options.accept_iteration_limit = true;
  const SolveSummary summary = solve(options, &world.graph);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

}  // namespace
}  // namespace loopsift
