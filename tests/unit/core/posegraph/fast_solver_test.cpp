// SPDX-License-Identifier: MIT
#include "core/posegraph/fast_solver.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>

#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

using test::RandomGraph;
using test::RandomGraphOptions;
using ::testing::HasSubstr;

// A workspace with the arena under it.
struct Workspace {
  explicit Workspace(const SolverLimits& limits) : arena(bytes(limits)), solver(&arena, limits) {}
  static std::size_t bytes(const SolverLimits& limits) {
    Arena measuring;
    SolverWorkspace on_nothing(&measuring, limits);
    return measuring.used_bytes();
  }
  Arena arena;
  SolverWorkspace solver;
};

SolveOptions tight() {
  SolveOptions options;
  options.relative_cost_tolerance = 1e-13;
  options.max_iterations = 200;
  return options;
}

double largest_difference(const PoseGraph& x, const PoseGraph& y) {
  double largest = 0;
  for (std::size_t n = 0; n < x.T_map_node.size(); ++n)
    largest = std::max(largest, (x.T_map_node[n].inverse() * y.T_map_node[n]).log().cwiseAbs().maxCoeff());
  return largest;
}

class FastSolverOnRandomGraphs : public ::testing::TestWithParam<unsigned> {};

TEST_P(FastSolverOnRandomGraphs, ComesToWhatCeresComesTo) {
  RandomGraphOptions options;
  options.seed = GetParam();
  options.fragments = 15 + 3 * static_cast<int>(GetParam());
  options.nodes_per_fragment = 1 + static_cast<int>(GetParam() % 4);
  RandomGraph world(options);
  Matrix6d A = Matrix6d::Identity();
  A(0, 4) = 0.3, A(1, 2) = -0.2, A(5, 0) = 0.4;  // information that couples the axes
  for (Loop loop : world.true_loops(2 + static_cast<int>(GetParam()))) {
    loop.information = A.transpose() * loop.information * A;
    append_frame_loops(world.graph, loop, &world.graph.loops);
  }
  PoseGraph with_ceres = world.graph, fast = world.graph;
  const SolveSummary reference = solve(tight(), &with_ceres);
  Workspace workspace(SolverLimits{});
  const SolveSummary summary = solve_fast(tight(), &workspace.solver, &fast);
  ASSERT_TRUE(reference.converged) << reference.message;
  ASSERT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(largest_difference(with_ceres, fast), 1e-6);
  EXPECT_NEAR(summary.final_cost, reference.final_cost, 1e-9 * reference.final_cost);
  EXPECT_NEAR(summary.initial_cost, reference.initial_cost, 1e-9 * reference.initial_cost);
  EXPECT_NEAR(summary.odometry_chi2, reference.odometry_chi2, 1e-5 * reference.odometry_chi2);
  EXPECT_NEAR(summary.loop_chi2, reference.loop_chi2, 1e-5 * reference.loop_chi2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, FastSolverOnRandomGraphs, ::testing::Range(1u, 9u));

// A false loop bends the graph by metres; the two solvers still have to find one minimum.
TEST(FastSolver, ComesToWhatCeresComesToUnderAFalseLoop) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    RandomGraphOptions options;
    options.seed = seed;
    RandomGraph world(options);
    for (const Loop& loop : world.true_loops(3)) append_frame_loops(world.graph, loop, &world.graph.loops);
    append_frame_loops(world.graph, world.false_loop(2, 14, 0.7), &world.graph.loops);
    PoseGraph with_ceres = world.graph, fast = world.graph;
    Workspace workspace(SolverLimits{});
    ASSERT_TRUE(solve(tight(), &with_ceres).converged);
    const SolveSummary summary = solve_fast(tight(), &workspace.solver, &fast);
    ASSERT_TRUE(summary.converged) << summary.message;
    EXPECT_LT(largest_difference(with_ceres, fast), 1e-6) << "seed " << seed;
  }
}

TEST(FastSolver, GivesTheSameBitsFromAUsedWorkspace) {
  RandomGraph world(RandomGraphOptions{});
  for (const Loop& loop : world.true_loops(5)) append_frame_loops(world.graph, loop, &world.graph.loops);
  PoseGraph first = world.graph, other = world.graph, second = world.graph;
  other.loops.resize(5);
  Workspace workspace(SolverLimits{});
  ASSERT_TRUE(solve_fast(SolveOptions{}, &workspace.solver, &first).converged);
  ASSERT_TRUE(solve_fast(SolveOptions{}, &workspace.solver, &other).converged);
  ASSERT_TRUE(solve_fast(SolveOptions{}, &workspace.solver, &second).converged);
  for (std::size_t n = 0; n < first.T_map_node.size(); ++n)
    EXPECT_EQ(first.T_map_node[n].matrix(), second.T_map_node[n].matrix());
}

TEST(FastSolver, StaysWhereItIsDoneAndNeedsFewIterationsNearby) {
  RandomGraph world(RandomGraphOptions{});
  for (const Loop& loop : world.true_loops(5)) append_frame_loops(world.graph, loop, &world.graph.loops);
  Workspace workspace(SolverLimits{});
  ASSERT_TRUE(solve_fast(tight(), &workspace.solver, &world.graph).converged);
  PoseGraph again = world.graph;
  const SolveSummary summary = solve_fast(SolveOptions{}, &workspace.solver, &again);
  EXPECT_TRUE(summary.converged);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_LT(largest_difference(world.graph, again), 1e-6);
}

TEST(FastSolver, KeepsTheFirstNodeOfEveryPartFixed) {
  RandomGraph world(RandomGraphOptions{});
  world.graph.odometry.erase(world.graph.odometry.begin() + 29);  // tracking lost between nodes 29 and 30
  append_frame_loops(world.graph, world.true_loop(1, 5), &world.graph.loops);
  PoseGraph with_ceres = world.graph, fast = world.graph;
  Workspace workspace(SolverLimits{});
  ASSERT_TRUE(solve(tight(), &with_ceres).converged);
  ASSERT_TRUE(solve_fast(tight(), &workspace.solver, &fast).converged);
  EXPECT_EQ(fast.T_map_node[0].matrix(), world.graph.T_map_node[0].matrix());
  EXPECT_EQ(fast.T_map_node[30].matrix(), world.graph.T_map_node[30].matrix());
  EXPECT_LT(largest_difference(with_ceres, fast), 1e-6);
}

TEST(FastSolver, LeavesOdometryAloneAsItIs) {
  RandomGraph world(RandomGraphOptions{});
  PoseGraph with_ceres = world.graph, fast = world.graph;
  Workspace workspace(SolverLimits{});
  const SolveSummary reference = solve(SolveOptions{}, &with_ceres);
  const SolveSummary summary = solve_fast(SolveOptions{}, &workspace.solver, &fast);
  EXPECT_TRUE(reference.converged) << reference.message;
  EXPECT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(largest_difference(world.graph, with_ceres), 1e-9);
  EXPECT_LT(largest_difference(world.graph, fast), 1e-9);
}

TEST(FastSolver, TakesEdgesThatKnowNothing) {
  RandomGraph world(RandomGraphOptions{});
  append_frame_loops(world.graph, world.true_loop(1, 12), &world.graph.loops);
  for (Edge& edge : world.graph.loops) edge.information.setZero();
  world.graph.odometry.back().information.setZero();
  Workspace workspace(SolverLimits{});
  const SolveSummary summary = solve_fast(SolveOptions{}, &workspace.solver, &world.graph);
  EXPECT_TRUE(summary.converged) << summary.message;
}

std::string failure_of(const SolverLimits& limits, const SolveOptions& options, PoseGraph graph) {
  const std::vector<Se3> before = graph.T_map_node;
  Workspace workspace(limits);
  const SolveSummary summary = solve_fast(options, &workspace.solver, &graph);
  EXPECT_FALSE(summary.converged);
  for (std::size_t n = 0; n < before.size(); ++n)
    EXPECT_EQ(std::memcmp(&before[n], &graph.T_map_node[n], sizeof(Se3)), 0) << "pose " << n << " moved";
  return summary.message;
}

TEST(FastSolver, SaysWhichOfItsLimitsAGraphExceeds) {
  RandomGraph world(RandomGraphOptions{});
  append_frame_loops(world.graph, world.true_loop(1, 12), &world.graph.loops);
  EXPECT_THAT(failure_of({59, 1000}, SolveOptions{}, world.graph), HasSubstr("takes 59"));
  EXPECT_THAT(failure_of({60, 40}, SolveOptions{}, world.graph), HasSubstr("40 blocks"));
}

TEST(FastSolver, NamesWhatIsMalformedAndLeavesThePoses) {
  RandomGraph world(RandomGraphOptions{});
  append_frame_loops(world.graph, world.true_loop(1, 12), &world.graph.loops);
  PoseGraph graph = world.graph;
  graph.T_map_node[7] = Se3(Eigen::Matrix3d::Identity(), {std::numeric_limits<double>::quiet_NaN(), 0, 0});
  EXPECT_THAT(failure_of({}, SolveOptions{}, graph), HasSubstr("node 7"));
  graph = world.graph;
  graph.odometry[3].information.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(failure_of({}, SolveOptions{}, graph), HasSubstr("odometry edge 3"));
  graph = world.graph;
  graph.loops[1].a = -1;
  EXPECT_THAT(failure_of({}, SolveOptions{}, graph), HasSubstr("loop edge 1"));
  graph = world.graph;
  graph.odometry[3].information *= -100.0;
  EXPECT_THAT(failure_of({}, SolveOptions{}, graph), HasSubstr("odometry edge 3"));
}

TEST(FastSolver, KeepsThePosesWhenTimeOrIterationsRunOut) {
  RandomGraph world(RandomGraphOptions{});
  append_frame_loops(world.graph, world.true_loop(1, 12), &world.graph.loops);
  SolveOptions options;
  options.time_limit_s = 0.0;
  EXPECT_THAT(failure_of({}, options, world.graph), HasSubstr("limit of"));
  options = SolveOptions{};
  options.max_iterations = 1;
  options.relative_cost_tolerance = 1e-15;
  EXPECT_THAT(failure_of({}, options, world.graph), HasSubstr("1 iterations"));
  options.accept_iteration_limit = true;
  Workspace workspace(SolverLimits{});
  const SolveSummary summary = solve_fast(options, &workspace.solver, &world.graph);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

}  // namespace
}  // namespace loopsift
