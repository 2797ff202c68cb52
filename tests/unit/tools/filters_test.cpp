// SPDX-License-Identifier: MIT
// Every filter on a graph with a known answer: true loops of the odometry's own quality, and false ones.
#include "tools/loopsift_tool/filters/filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <cctype>
#include <ostream>
#include <random>
#include <set>
#include <string>

#include "tests/support/random_graph.hpp"
#include "tools/loopsift_tool/filters/chi_squared.hpp"
#include "tools/loopsift_tool/filters/max_clique.hpp"

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
void PrintTo(const Expectation& expected, std::ostream* out) { *out << expected.filter; }

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
                         ::testing::Values(Expectation{"Cauchy loss", 7, 0.45},
                                           Expectation{"max-mixtures", 7, 0.45}, Expectation{"PCM", 8, 0.45},
                                           Expectation{"switchable constraints", 2, 0.75},
                                           Expectation{"dynamic covariance scaling", 3, 0.6},
                                           Expectation{"line process", 8, 0.45},
                                           Expectation{"GNC-TLS", 8, 0.45}),
                         [](const auto& test) {
                           std::string name = test.param.filter;
                           name.erase(std::remove_if(name.begin(), name.end(),
                                                     [](unsigned char c) { return std::isalnum(c) == 0; }),
                                      name.end());
                           return name;
                         });

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

// Least squares first: one bad loop shows as the edges that disagree, many pull the others along.
TEST(EdgePruning, RemovesASingleFalseLoop) {
  Case c(1, 8, 0);
  c.loops.push_back(c.world.false_loop(2, 15, 1.0));
  const Expected<FilterResult> result = run_edge_pruning(c.world.graph, c.loops);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(c.false_accepted(*result), 0);
  EXPECT_EQ(result->weights.back(), 0.0);
  EXPECT_LT(c.world.rmse_m(result->graph), c.world.rmse_m(c.world.graph));
  EXPECT_EQ(result->solves, 2);
}

// With w = 1 and s = 1 the null hypothesis is the loop itself: ties go to the loop.
TEST(MaxMixtures, WithoutANullHypothesisAreLeastSquares) {
  const Case c(1);
  MaxMixturesOptions options;
  options.null_weight = options.null_information = 1.0;
  const Expected<FilterResult> result = run_max_mixtures(c.world.graph, c.loops, options);
  const Expected<FilterResult> all = run_all(c.world.graph, c.loops);
  ASSERT_TRUE(result.ok() && all.ok());
  EXPECT_EQ(result->accepted.size(), c.loops.size());
  EXPECT_NEAR(c.world.rmse_m(result->graph), c.world.rmse_m(all->graph), 1e-3);
}

// The camera of these graphs goes round in three seconds.
RrrOptions clusters_within(double seconds) {
  RrrOptions options;
  options.cluster_window_s = seconds;
  return options;
}

TEST(Rrr, KeepsClustersThatAgree) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Case c(seed);
    const Expected<FilterResult> result = run_rrr(c.world.graph, c.loops, clusters_within(0.1));
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_EQ(c.false_accepted(*result), 0) << "seed " << seed;
    EXPECT_GE(c.true_accepted(*result), 6) << "seed " << seed;
    EXPECT_LT(c.world.rmse_m(result->graph), 0.5 * c.world.rmse_m(c.world.graph));
  }
}

TEST(Rrr, ThrowsAFalseLoopOutOfAClusterOfTrueOnes) {
  Case c(2, 6, 0);
  c.loops.push_back(c.world.false_loop(c.loops[0].i.value, c.loops[0].j.value, 0.05));
  const Expected<FilterResult> result = run_rrr(c.world.graph, c.loops, clusters_within(1e3));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(c.false_accepted(*result), 0);
  EXPECT_GE(c.true_accepted(*result), 4);
}

TEST(Rrr, RejectsAClusterThatFalseLoopsRuin) {
  const Case c(1);  // as many false as true, all in one
  const Expected<FilterResult> result = run_rrr(c.world.graph, c.loops, clusters_within(1e3));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_TRUE(result->accepted.empty());
}

TEST(PairwiseConsistency, ASharedErrorIsConsistent) {
  Case c(1, 0, 0);
  const Loop truth = c.world.true_loop(1, 11);
  const Se3 shift(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.7, 0, 0));
  // Three loops that agree with each other, shifted alike, against two that agree with the truth.
  for (int k = 0; k < 3; ++k) {
    c.loops.push_back(truth);
    c.loops.back().T_i_j = truth.T_i_j * shift;
  }
  c.loops.push_back(truth);
  c.loops.push_back(c.world.true_loop(2, 12));
  for (std::size_t k = 0; k < c.loops.size(); ++k) c.loops[k].id.value = static_cast<int>(k);
  const Expected<FilterResult> result = run_pairwise_consistency(c.world.graph, c.loops);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->accepted, (std::vector<LoopId>{LoopId{0}, LoopId{1}, LoopId{2}}));
}

std::vector<std::vector<bool>> graph_of(int vertices, const std::vector<std::pair<int, int>>& edges) {
  const auto n = static_cast<std::size_t>(vertices);
  std::vector<std::vector<bool>> adjacent(n, std::vector<bool>(n, false));
  for (const auto& [a, b] : edges) {
    adjacent[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] = true;
    adjacent[static_cast<std::size_t>(b)][static_cast<std::size_t>(a)] = true;
  }
  return adjacent;
}

TEST(MaxCliqueSearch, SmallGraphs) {
  EXPECT_TRUE(max_clique({}, 1000).members.empty());
  EXPECT_EQ(max_clique(graph_of(3, {}), 1000).members.size(), 1U);
  // A triangle 0 1 2 and a square with one diagonal missing.
  const auto adjacent = graph_of(7, {{0, 1}, {1, 2}, {0, 2}, {3, 4}, {4, 5}, {5, 6}, {6, 3}});
  EXPECT_EQ(max_clique(adjacent, 1000).members, (std::vector<int>{0, 1, 2}));
}

TEST(MaxCliqueSearch, EqualsExhaustiveSearch) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::pair<int, int>> edges;
    for (int a = 0; a < 12; ++a)
      for (int b = a + 1; b < 12; ++b)
        if (random() % 2 == 0) edges.emplace_back(a, b);
    const auto adjacent = graph_of(12, edges);
    std::size_t largest = 0;
    for (unsigned set = 1; set < 1U << 12; ++set) {
      bool clique = true;
      for (std::size_t a = 0; a < 12; ++a)
        for (std::size_t b = a + 1; b < 12; ++b)
          if ((set >> a & 1U) != 0 && (set >> b & 1U) != 0 && !adjacent[a][b]) clique = false;
      if (clique) largest = std::max(largest, std::bitset<12>(set).count());
    }
    const MaxClique found = max_clique(adjacent, 100000);
    EXPECT_TRUE(found.proven);
    EXPECT_EQ(found.members.size(), largest);
    for (const int a : found.members)
      for (const int b : found.members)
        EXPECT_TRUE(a == b || adjacent[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)]);
  }
}

TEST(MaxCliqueSearch, SaysWhenItsBudgetRanOut) {
  std::mt19937 random(3);
  std::vector<std::pair<int, int>> edges;
  for (int a = 0; a < 100; ++a)
    for (int b = a + 1; b < 100; ++b)
      if (random() % 10 != 0) edges.emplace_back(a, b);
  const MaxClique found = max_clique(graph_of(100, edges), 200);
  EXPECT_FALSE(found.proven);
  EXPECT_GE(found.members.size(), 10U);
}

TEST(ChiSquared, QuantilesOfTheTables) {
  EXPECT_EQ(chi2_quantile_95(0), 0.0);
  EXPECT_NEAR(chi2_quantile_95(6), 12.592, 0.03);
  EXPECT_NEAR(chi2_quantile_95(60), 79.082, 0.05);
  EXPECT_NEAR(chi2_quantile_95(600), 658.094, 0.2);
}

}  // namespace
}  // namespace loopsift::tool
