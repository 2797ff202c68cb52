// SPDX-License-Identifier: MIT
// Every filter on a graph with a known answer: true loops of the odometry's own quality, and false ones.
#include "tools/loopsift_tool/filters/filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/support/random_graph.hpp"

namespace loopsift::tool {
namespace {

using test::RandomGraph;
using test::RandomGraphOptions;
using ::testing::HasSubstr;

struct Case {
  explicit Case(unsigned seed, int true_count = 8, int false_count = 8) : world(make_options(seed)) {
    loops = world.true_loops(true_count);
    for (const Loop& loop : loops) true_ids.insert(loop.id.value);
    const std::vector<Loop> wrong = world.false_loops(false_count, 1.0);
    loops.insert(loops.end(), wrong.begin(), wrong.end());
  }
  static RandomGraphOptions make_options(unsigned seed) {
    RandomGraphOptions options;
    options.seed = seed;
    return options;
  }
  [[nodiscard]] int false_accepted(const FilterResult& result) const {
    int count = 0;
    for (const LoopId id : result.accepted) count += true_ids.count(id.value) == 0 ? 1 : 0;
    return count;
  }
  [[nodiscard]] int true_accepted(const FilterResult& result) const {
    return static_cast<int>(result.accepted.size()) - false_accepted(result);
  }
  RandomGraph world;
  std::vector<Loop> loops;
  std::set<int> true_ids;
};

TEST(Filters, NoneKeepsTheOdometryAndAllIsRuinedByFalseLoops) {
  const Case c(1);
  const Expected<FilterResult> none = run_none(c.world.graph, c.loops), all = run_all(c.world.graph, c.loops);
  ASSERT_TRUE(none.ok() && all.ok());
  EXPECT_TRUE(none->accepted.empty());
  EXPECT_NEAR(c.world.rmse_m(none->graph), c.world.rmse_m(c.world.graph), 1e-6);
  EXPECT_EQ(all->accepted.size(), c.loops.size());
  EXPECT_GT(c.world.rmse_m(all->graph), 2.0 * c.world.rmse_m(c.world.graph));
}

TEST(Filters, AllIsTheBestThereIsWhenNoLoopIsFalse) {
  const Case c(2, 8, 0);
  const Expected<FilterResult> all = run_all(c.world.graph, c.loops);
  ASSERT_TRUE(all.ok());
  EXPECT_LT(c.world.rmse_m(all->graph), 0.6 * c.world.rmse_m(c.world.graph));
}

// What a filter has to reach with eight true and eight false loops. Switches and scales below one half are
// ordinary for true edges, whose χ² they are held against with a prior of 1.
struct Expectation {
  const char* filter;
  int true_accepted;   // at least
  double error_ratio;  // at most, of the odometry's
};

class RobustFilters : public ::testing::TestWithParam<Expectation> {
 protected:
  [[nodiscard]] static const NamedFilter& filter() {
    for (const NamedFilter& named : published_filters())
      if (std::string(named.name) == GetParam().filter) return named;
    ADD_FAILURE() << GetParam().filter << " is not in the list";
    return published_filters()[0];
  }
};

TEST_P(RobustFilters, RefuseFalseLoopsAndImproveTheTrajectory) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Case c(seed);
    const Expected<FilterResult> result = filter().run(c.world.graph, c.loops);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_EQ(c.false_accepted(*result), 0) << "seed " << seed;
    EXPECT_GE(c.true_accepted(*result), GetParam().true_accepted) << "seed " << seed;
    EXPECT_LT(c.world.rmse_m(result->graph), GetParam().error_ratio * c.world.rmse_m(c.world.graph));
    ASSERT_EQ(result->weights.size(), c.loops.size());
    for (const double weight : result->weights) EXPECT_TRUE(weight >= 0.0 && weight <= 1.0) << weight;
  }
}

TEST_P(RobustFilters, NameALoopOfAFragmentThatIsNotThere) {
  const Case c(1, 1, 0);
  std::vector<Loop> loops = c.loops;
  loops[0].j = FragmentId{99};
  const Expected<FilterResult> result = filter().run(c.world.graph, loops);
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().message, HasSubstr("99"));
}

TEST_P(RobustFilters, TakeNoLoopsAtAll) {
  const Case c(1, 0, 0);
  const Expected<FilterResult> result = filter().run(c.world.graph, c.loops);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_TRUE(result->accepted.empty());
}

INSTANTIATE_TEST_SUITE_P(Published, RobustFilters,
                         ::testing::Values(Expectation{"switchable constraints", 2, 0.75},
                                           Expectation{"dynamic covariance scaling", 3, 0.6},
                                           Expectation{"line process", 8, 0.45},
                                           Expectation{"GNC-TLS", 8, 0.45}));

// Truncated least squares gives what it keeps full weight and what it does not none.
TEST(Gnc, EndsWhereLeastSquaresOnItsLoopsEnds) {
  const Case c(1);
  const Expected<FilterResult> gnc = run_gnc_tls(c.world.graph, c.loops);
  ASSERT_TRUE(gnc.ok()) << gnc.error().message;
  std::vector<Loop> kept;
  for (const Loop& loop : c.loops)
    if (c.true_ids.count(loop.id.value) != 0) kept.push_back(loop);
  ASSERT_EQ(gnc->accepted.size(), kept.size());
  const Expected<FilterResult> all = run_all(c.world.graph, kept);
  ASSERT_TRUE(all.ok());
  for (std::size_t n = 0; n < all->graph.T_map_node.size(); ++n)
    EXPECT_LT((all->graph.T_map_node[n].inverse() * gnc->graph.T_map_node[n]).log().norm(), 1e-3);
}

TEST(Gnc, KeepsEverythingWhereNothingIsOutOfBounds) {
  const Case c(2, 4, 0);
  GncOptions options;
  options.noise_bound_squared = 1e9;
  const Expected<FilterResult> result = run_gnc_tls(c.world.graph, c.loops, options);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->accepted.size(), 4u);
  EXPECT_EQ(result->solves, 1);
}

// μ follows the loops' information, so that its unit does not matter when the odometry has the same.
TEST(LineProcess, DoesNotDependOnTheUnitOfInformation) {
  const Case c(3);
  PoseGraph graph = c.world.graph;
  std::vector<Loop> loops = c.loops;
  for (Edge& edge : graph.odometry) edge.information *= 100.0;
  for (Loop& loop : loops) loop.information *= 100.0;
  const Expected<FilterResult> one = run_line_process(c.world.graph, c.loops),
                               other = run_line_process(graph, loops);
  ASSERT_TRUE(one.ok() && other.ok());
  for (std::size_t k = 0; k < loops.size(); ++k) EXPECT_NEAR(one->weights[k], other->weights[k], 1e-3);
}

TEST(LineProcess, SaysThatLoopsWithoutInformationAreOfNoUse) {
  const Case c(1, 2, 0);
  std::vector<Loop> loops = c.loops;
  for (Loop& loop : loops) loop.information.setZero();
  const Expected<FilterResult> result = run_line_process(c.world.graph, loops);
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().message, HasSubstr("information"));
}

}  // namespace
}  // namespace loopsift::tool
