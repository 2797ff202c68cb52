// SPDX-License-Identifier: MIT
#include "core/sifter/sifter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/unit/core/sifter/sifting.hpp"

namespace loopsift {
namespace {

using test::error;
using test::FragmentWorld;
using test::Sifting;
using test::together;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Lt;
using ::testing::Not;

SifterOptions with_score(ScoreKind kind) {
  SifterOptions options;
  options.score = kind;
  return options;
}

const ScoreKind kBothScores[] = {ScoreKind::kPlain, ScoreKind::kPosterior};

TEST(Sifter, ATrueLoopIsAcceptedAndTakesTheDriftAway) {
  const FragmentWorld world;
  ASSERT_GT(world.rmse_m(world.odometry()), 0.04);
  for (const ScoreKind kind : kBothScores) {
    Sifting sifting(world, with_score(kind));
    EXPECT_THAT(sifting.sift({test::true_loops(world)[0]}), ElementsAre(0));
    EXPECT_LT(world.rmse_m(sifting.poses()), 0.5 * world.rmse_m(world.odometry()));
    EXPECT_LT(sifting.sifter.best_score(), sifting.sifter.base_score());
    const SiftedLoop& record = sifting.of(0);
    EXPECT_EQ(record.decision, Decision::kAccepted);
    EXPECT_EQ(record.reason, Reason::kImproves);
    EXPECT_EQ(record.rank, 0);
    EXPECT_EQ(record.frame_decided, 27) << "the newest frame of the map";
    EXPECT_LT(record.tested_score, record.best_score_before);
    EXPECT_GT(record.views, 0);
  }
}

TEST(Sifter, WrongLoopsAreRejectedAmongTrueOnes) {
  const FragmentWorld world;
  for (const ScoreKind kind : kBothScores) {
    Sifting sifting(world, with_score(kind));
    const std::vector<int> accepted =
        sifting.sift(together(test::wrong_loops(world), test::true_loops(world)));
    EXPECT_THAT(accepted, Not(IsEmpty()));
    EXPECT_THAT(accepted, Each(Lt(10)));
    EXPECT_LT(world.rmse_m(sifting.poses()), 0.5 * world.rmse_m(world.odometry()));
    for (const SiftedLoop& record : sifting.sifter.records())
      EXPECT_NE(record.decision, Decision::kPending) << record.loop.id.value;
  }
}

TEST(Sifter, WithoutATrueLoopTheMapStaysAsTheOdometryHasIt) {
  const FragmentWorld world;
  Sifting sifting(world);
  EXPECT_THAT(sifting.sift(test::wrong_loops(world)), IsEmpty());
  for (std::size_t f = 0; f < world.odometry().size(); ++f)
    EXPECT_LT((sifting.poses()[f].inverse() * world.odometry()[f]).log().norm(), 1e-9);
  EXPECT_EQ(sifting.sifter.best_score(), sifting.sifter.base_score());
}

// A loop that flings fragments away lowers the misfit (what does not overlap costs nothing), and the
// posterior must not take it for that.
TEST(Sifter, AFlingIsNeverAcceptedByThePosterior) {
  const FragmentWorld world;
  std::vector<Loop> flings;
  int id = 10;
  for (const auto& [i, j] : {std::pair{0, 6}, {0, 4}, {2, 6}})
    for (const Vector6d& e :
         {error(5, 0, 0, 0), error(0, -5, 0, 0), error(0, 0, -5, 0.5), error(-4, 2, 3, -1)})
      flings.push_back(world.loop(id++, i, j, e));
  EXPECT_THAT(Sifting(world).sift(flings), IsEmpty());
  EXPECT_THAT(Sifting(world).sift(together(flings, test::true_loops(world))), Each(Lt(10)));
}

TEST(Sifter, RanksByImprovementBestFirst) {
  const FragmentWorld world;
  Sifting sifting(world);
  (void)sifting.sift(together(test::wrong_loops(world), test::true_loops(world)));
  const Span<const SiftedLoop> known = sifting.sifter.records();
  std::vector<SiftedLoop> records(known.begin(), known.end());
  std::sort(records.begin(), records.end(),
            [](const SiftedLoop& a, const SiftedLoop& b) { return a.rank < b.rank; });
  for (std::size_t k = 0; k < records.size(); ++k) {
    EXPECT_EQ(records[k].rank, static_cast<int>(k));
    EXPECT_NEAR(records[k].improvement, sifting.sifter.base_score() - records[k].single_score, 1e-12);
    if (k > 0) {
      EXPECT_GE(records[k - 1].improvement, records[k].improvement);
    }
  }
  EXPECT_LT(records.front().loop.id.value, 10) << "a true loop is the most effective";
  EXPECT_GE(records.back().loop.id.value, 10);
}

TEST(Sifter, TestedScoresExplainTheDecisions) {
  const FragmentWorld world;
  for (const ScoreKind kind : kBothScores) {
    Sifting sifting(world, with_score(kind));
    (void)sifting.sift(together(test::wrong_loops(world), test::true_loops(world)));
    for (const SiftedLoop& record : sifting.sifter.records()) {
      if (record.reason == Reason::kImproves || record.reason == Reason::kInsignificant) {
        EXPECT_LT(record.tested_score, record.best_score_before);
      }
      if (record.reason == Reason::kNoImprovement) {
        EXPECT_GE(record.tested_score, record.best_score_before);
      }
      EXPECT_LE(record.best_score_before, sifting.sifter.base_score());
    }
    const SifterCounts& counts = sifting.sifter.counts();
    EXPECT_EQ(counts.scored, 7);
    EXPECT_EQ(counts.tested, 7);
  }
}

TEST(Sifter, WithNoLoopsThereIsNothingToDo) {
  const FragmentWorld world;
  Sifting sifting(world);
  sifting.add({});
  EXPECT_FALSE(sifting.sifter.step());
  EXPECT_TRUE(sifting.sifter.finish());
  EXPECT_TRUE(sifting.sifter.graph().loops.empty());
  EXPECT_LT(std::abs(world.rmse_m(sifting.poses()) - world.rmse_m(world.odometry())), 1e-9);
}

TEST(Sifter, ALoopOfAFragmentThatIsNotThereIsSaidToBeOne) {
  const FragmentWorld world;
  Sifting sifting(world);
  Loop unknown = world.loop(10, 0, 6), invalid = world.loop(11, 0, 6), itself = world.loop(12, 0, 6);
  unknown.j = FragmentId{7};
  invalid.i = FragmentId{};
  itself.j = itself.i;
  EXPECT_THAT(sifting.sift({unknown, invalid, itself, test::true_loops(world)[0]}), ElementsAre(0));
  for (const int id : {10, 11, 12}) {
    EXPECT_EQ(sifting.of(id).decision, Decision::kRejected);
    EXPECT_EQ(sifting.of(id).reason, Reason::kNoFragment);
    EXPECT_EQ(sifting.of(id).rank, -1);
  }
}

TEST(Sifter, ALoopThatIsNotANumberIsSaidToBeUnsolvable) {
  const FragmentWorld world;
  Sifting sifting(world);
  Loop broken = world.loop(10, 0, 6);
  broken.T_i_j = Se3(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(std::nan("")));
  EXPECT_THAT(sifting.sift({broken, test::true_loops(world)[0]}), ElementsAre(0));
  EXPECT_EQ(sifting.of(10).reason, Reason::kSolveFailed);
}

TEST(Sifter, ALoopWaitsForItsFragmentToClose) {
  const FragmentWorld world;
  Sifting growing;
  const Fragment* previous = nullptr;
  for (const Fragment& fragment : world.fragments()) {
    growing.grow(previous, fragment,
                 fragment.id.value == 2 ? std::vector<Loop>{world.loop(0, 0, 6)} : std::vector<Loop>{});
    previous = &fragment;
    if (fragment.id.value < 2) continue;
    EXPECT_EQ(growing.of(0).decision, fragment.id.value < 6 ? Decision::kPending : Decision::kAccepted);
    if (fragment.id.value < 6) {
      EXPECT_EQ(growing.of(0).reason, Reason::kWaits);
    }
  }
}

TEST(Sifter, GrowingMapEndsWithWhatTheBatchAccepts) {
  const FragmentWorld world;
  const std::vector<Loop> loops = together(test::wrong_loops(world), {test::true_loops(world)[0]});
  Sifting batch(world), growing;
  EXPECT_THAT(batch.sift(loops), ElementsAre(0));
  const Fragment* previous = nullptr;
  for (const Fragment& fragment : world.fragments()) {
    std::vector<Loop> proposed;
    for (const Loop& loop : loops)
      if (loop.j == fragment.id) proposed.push_back(loop);
    growing.grow(previous, fragment, proposed);
    previous = &fragment;
  }
  EXPECT_THAT(growing.accepted(), ElementsAre(0)) << "as the map grew";
  EXPECT_TRUE(growing.sifter.finish());
  EXPECT_EQ(growing.accepted(), batch.accepted());
  for (std::size_t f = 0; f < world.truth().size(); ++f)
    EXPECT_LT((growing.poses()[f].inverse() * batch.poses()[f]).log().norm(), 1e-3);
}

TEST(Sifter, WhatIsDecidedIsNotTestedAgainUntilTheAcceptedLoopsBeforeItChange) {
  const FragmentWorld world;
  Sifting sifting(world);
  EXPECT_THAT(sifting.sift({test::true_loops(world)[0]}), ElementsAre(0));
  sifting.add(test::wrong_loops(world));
  EXPECT_EQ(sifting.of(10).decision, Decision::kPending);
  EXPECT_EQ(sifting.sifter.pending(), 4);
  const std::int64_t tested = sifting.sifter.counts().tested;
  sifting.work();
  EXPECT_EQ(sifting.sifter.counts().tested, tested + 4);
  EXPECT_EQ(sifting.of(10).decision, Decision::kRejected);
  EXPECT_EQ(sifting.sifter.pending(), 0);
  EXPECT_THAT(sifting.accepted(), ElementsAre(0));
  EXPECT_FALSE(sifting.sifter.step());
}

// Whatever order the steps take, they end with what one walk through the ranking accepts.
TEST(Sifter, LoopsThatComeOneByOneEndLikeLoopsThatComeAtOnce) {
  const FragmentWorld world;
  std::vector<Loop> loops = together(test::wrong_loops(world), test::true_loops(world));
  Sifting batch(world);
  const std::vector<int> accepted = batch.sift(loops);
  for (const bool reversed : {false, true}) {
    Sifting sifting(world);
    if (reversed) std::reverse(loops.begin(), loops.end());
    for (const Loop& loop : loops) {
      sifting.add({loop});
      sifting.work();
    }
    EXPECT_TRUE(sifting.sifter.finish());
    EXPECT_EQ(sifting.accepted(), accepted);
    const std::vector<Se3>&a = sifting.sifter.T_map_node(), &b = batch.sifter.T_map_node();
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Se3)), 0);
  }
}

// A loop off by less than the drift improves the odometry's map. Once a true one is in, it does no longer,
// and what was published is taken back.
TEST(Sifter, AnAcceptedLoopIsRevokedWhenABetterOneMakesItHarmful) {
  const FragmentWorld world;
  SifterOptions options;
  options.challenge = false;
  Sifting sifting(world, options);
  sifting.add({world.loop(10, 0, 6, error(0.0, 0.0, -0.05, -0.02))});
  sifting.work();
  ASSERT_THAT(sifting.accepted(), ElementsAre(10));
  EXPECT_EQ(sifting.sifter.epoch(), 1);
  const double rmse = world.rmse_m(sifting.poses());
  sifting.add({world.loop(0, 0, 6)});
  sifting.work();
  EXPECT_THAT(sifting.accepted(), ElementsAre(0));
  EXPECT_EQ(sifting.of(10).decision, Decision::kRevoked);
  EXPECT_EQ(sifting.of(10).revisions, 1);
  EXPECT_EQ(sifting.sifter.counts().revoked, 1);
  EXPECT_GT(sifting.sifter.epoch(), 1);
  EXPECT_LT(world.rmse_m(sifting.poses()), rmse);
}

TEST(Sifter, TheSameLoopTwiceIsAcceptedOnce) {
  const FragmentWorld world;
  Sifting sifting(world);
  Loop again = test::true_loops(world)[0];
  again.id.value = 1;
  EXPECT_THAT(sifting.sift({test::true_loops(world)[0], again}), ElementsAre(0));
  EXPECT_EQ(sifting.of(1).reason, Reason::kSame);
}

// A loop that says what the odometry says, weakly, takes back a little of what others bent: the prior is
// better for it, and no view can tell.
TEST(Sifter, ALoopThatChangesNothingThatAViewSeesIsNotKept) {
  const FragmentWorld world;
  Loop echo = world.loop(1, 2, 3);
  echo.T_i_j = world.odometry()[2].inverse() * world.odometry()[3];
  echo.information *= 0.0003;
  Sifting sifting(world);
  EXPECT_THAT(sifting.sift({test::true_loops(world)[0], echo}), ElementsAre(0));
  EXPECT_EQ(sifting.of(1).reason, Reason::kNoChange);
  EXPECT_LT(sifting.of(1).tested_score, sifting.of(1).best_score_before) << "by the prior alone";
  EXPECT_EQ(sifting.of(1).views, 0);
}

TEST(Sifter, OfTwoLoopsThatContradictEachOtherTheTrueOneIsAccepted) {
  const FragmentWorld world;
  for (const double off : {0.3, -0.8}) {
    Sifting sifting(world);
    EXPECT_THAT(sifting.sift({world.loop(10, 0, 6, error(off, 0, 0, 0.2)), test::true_loops(world)[0]}),
                ElementsAre(0));
  }
}

TEST(Sifter, AFullListDropsTheLowestRankedAndKeepsWhatIsAccepted) {
  const FragmentWorld world;
  SifterOptions options;
  options.max_loops = 4;
  Sifting sifting(world, options);
  sifting.add(together({test::true_loops(world)[0]}, {test::wrong_loops(world)[0]}));
  sifting.work();
  ASSERT_THAT(sifting.accepted(), ElementsAre(0));
  std::vector<Loop> flood;
  for (int k = 0; k < 10000; ++k)
    flood.push_back(world.loop(100 + k, 0, 6, error(0.4 + 1e-4 * k, 0.2, 0, 0.3)));
  sifting.add(flood);
  EXPECT_EQ(sifting.sifter.records().size(), 4U);
  EXPECT_EQ(sifting.sifter.dropped(), 9998);
  sifting.work();
  EXPECT_THAT(sifting.accepted(), ElementsAre(0));
  sifting.add({test::true_loops(world)[1]});
  sifting.work();
  EXPECT_EQ(sifting.sifter.dropped(), 9999);
  EXPECT_GT(sifting.of(1).views, 0) << "the newcomer took the place of the lowest ranked, and was tested";
}

TEST(Sifter, PastTheTimeLimitTheMapStaysAsItWas) {
  const FragmentWorld world;
  Sifting sifting(world);
  sifting.add(test::true_loops(world));
  sifting.work();
  const std::vector<int> accepted = sifting.accepted();
  ASSERT_THAT(accepted, Not(IsEmpty()));
  EXPECT_FALSE(sifting.sifter.finish(0.0));
  EXPECT_EQ(sifting.sifter.unfinished(), 3);
  EXPECT_EQ(sifting.accepted(), accepted);
  for (const int id : accepted) EXPECT_EQ(sifting.of(id).decision, Decision::kAccepted);
  int steps = 0;
  EXPECT_FALSE(sifting.sifter.finish(1e9, [&] { return ++steps < 3; })) << "as good as a limit";
  EXPECT_EQ(steps, 3);
  EXPECT_EQ(sifting.accepted(), accepted);
  EXPECT_TRUE(sifting.sifter.finish());
  EXPECT_EQ(sifting.sifter.unfinished(), 0);
}

TEST(Sifter, GraphHoldsTheFrameLoopsOfAcceptedLoopsOnly) {
  const FragmentWorld world;
  Sifting sifting(world);
  (void)sifting.sift(together(test::wrong_loops(world), {test::true_loops(world)[0]}));
  const PoseGraph graph = sifting.sifter.graph();
  EXPECT_EQ(graph.odometry.size(), world.graph().odometry.size());
  EXPECT_EQ(graph.loops.size(), 3U) << "two nodes each: reference to all, once";
  for (const Edge& edge : graph.loops) EXPECT_EQ(edge.loop.value, 0);
}

TEST(Sifter, GivesTheSameBitsTwice) {
  const FragmentWorld world;
  const std::vector<Loop> loops = together(test::wrong_loops(world), test::true_loops(world));
  Sifting first(world), second(world);
  EXPECT_EQ(first.sift(loops), second.sift(loops));
  for (std::size_t k = 0; k < loops.size(); ++k) {
    EXPECT_EQ(first.record(k).single_score, second.record(k).single_score);
    EXPECT_EQ(first.record(k).tested_score, second.record(k).tested_score);
    EXPECT_EQ(first.record(k).views, second.record(k).views);
  }
  const std::vector<Se3>&a = first.sifter.T_map_node(), &b = second.sifter.T_map_node();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Se3)), 0);
}

TEST(Sifter, OrderOfArrivalDoesNotMatter) {
  const FragmentWorld world;
  std::vector<Loop> loops = together(test::wrong_loops(world), test::true_loops(world));
  Sifting first(world), second(world);
  const std::vector<int> accepted = first.sift(loops);
  std::reverse(loops.begin(), loops.end());
  EXPECT_EQ(second.sift(loops), accepted);
}

TEST(Sifter, ReportsProgress) {
  const FragmentWorld world;
  Sifting sifting(world);
  std::vector<std::size_t> done;
  sifting.sifter.on_progress([&](std::size_t n, std::size_t of) {
    done.push_back(n);
    EXPECT_EQ(of, 3U);
  });
  (void)sifting.sift(test::true_loops(world));
  ASSERT_GE(done.size(), 6U) << "three alone, three tested";
  EXPECT_TRUE(std::is_sorted(done.begin(), done.begin() + 6));
  EXPECT_EQ(done.back(), 3U);
}

}  // namespace
}  // namespace loopsift
