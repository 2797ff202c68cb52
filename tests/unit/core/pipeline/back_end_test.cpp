// SPDX-License-Identifier: MIT
#include "core/pipeline/back_end.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/unit/core/pipeline/sifted_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::grow;
using test::InArena;
using test::small_back_end;
using test::view_of;

// How far a loop is from the truth.
double error_m(const FragmentWorld& world, const Loop& loop) {
  const Se3 truth = world.truth()[loop.i.index()].inverse() * world.truth()[loop.j.index()];
  return (truth.inverse() * loop.T_i_j).translation().norm();
}

TEST(BackEnd, ProposesSiftsAndTakesTheDriftAway) {
  const FragmentWorld world;
  InArena<BackEnd> back_end(small_back_end(true));
  int changes = 0;
  for (const Fragment& fragment : world.fragments()) changes += grow(&*back_end, fragment) ? 1 : 0;
  back_end->finish();
  EXPECT_EQ(back_end->fragment_count(), 7);
  EXPECT_GT(changes, 0);
  ASSERT_FALSE(back_end->proposals().empty());
  EXPECT_EQ(back_end->sifter().records().size(), back_end->proposals().size());
  ASSERT_FALSE(back_end->sifter().accepted().empty());
  for (const Loop& loop : back_end->sifter().accepted())
    EXPECT_LT(error_m(world, loop), 0.05) << loop.i.value << ' ' << loop.j.value;
  EXPECT_LT(world.rmse_m(back_end->T_map_fragment()), 0.5 * world.rmse_m(world.odometry()));
  EXPECT_LT(back_end->dmp_final(), back_end->dmp_odometry());
  EXPECT_EQ(back_end->proposal_times().count(), 7);
}

TEST(BackEnd, CorrectionIsWhatMovesTheNewestFragment) {
  const FragmentWorld world;
  InArena<BackEnd> back_end(small_back_end(false));
  EXPECT_EQ(back_end->T_map_odom().matrix(), Se3().matrix());
  for (const Fragment& fragment : world.fragments()) (void)grow(&*back_end, fragment);
  EXPECT_LT(back_end->T_map_odom().log().norm(), 1e-9);
  const Loop loop = world.loop(0, 0, 6);
  back_end->add_loops(Span<const Loop>(&loop, 1));
  EXPECT_EQ(back_end->sifter().records()[0].decision, Decision::kPending) << "not yet looked at";
  back_end->finish();
  EXPECT_EQ(back_end->sifter().records()[0].decision, Decision::kAccepted);
  const FragmentFrame* frames = world.fragments()[6].frames.data();
  const Se3 T_odom_node = world.odometry()[6] * frames[2].T_fragment_camera;
  const Se3 T_map_node = back_end->T_map_fragment()[6] * frames[2].T_fragment_camera;
  // The two nodes of a fragment may be corrected a little differently.
  EXPECT_LT(((back_end->T_map_odom() * T_odom_node).translation() - T_map_node.translation()).norm(), 0.02);
}

TEST(BackEnd, LoopsHandedInAreSiftedWithTheNextSteps) {
  const FragmentWorld world;
  InArena<BackEnd> back_end(small_back_end(false));
  for (std::size_t f = 0; f < 6; ++f) (void)grow(&*back_end, world.fragments()[f]);
  const Loop loop = world.loop(0, 0, 5);
  back_end->add_loops(Span<const Loop>(&loop, 1));
  EXPECT_EQ(back_end->sifter().counts().scored, 0);
  (void)grow(&*back_end, world.fragments()[6]);
  EXPECT_GE(back_end->sifter().counts().tested, 1);
  EXPECT_NE(back_end->sifter().records()[0].decision, Decision::kPending);
  EXPECT_EQ(back_end->proposals().size(), 1U);
}

TEST(BackEnd, BatchInsertionEndsLikeFragmentByFragment) {
  const FragmentWorld world;
  const std::vector<Loop> loops = {world.loop(0, 0, 6), world.loop(1, 1, 5)};
  InArena<BackEnd> batch(small_back_end(false)), online(small_back_end(false));
  for (const Fragment& fragment : world.fragments()) {
    EXPECT_TRUE(batch->insert_fragment(fragment));
    (void)grow(&*online, fragment);
  }
  batch->update_sifter();
  for (InArena<BackEnd>* back_end : {&batch, &online}) {
    (*back_end)->add_loops(view_of(loops));
    (*back_end)->finish();
  }
  const std::vector<Se3> a = batch->T_map_fragment(), b = online->T_map_fragment();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Se3)), 0);
}

// Tracking is lost before fragment 4; what comes after lies wherever the odometry began anew.
TEST(BackEnd, APieceAfterALossIsAnchoredByAnAcceptedLoop) {
  const FragmentWorld world;
  InArena<BackEnd> back_end(small_back_end(false));
  EXPECT_TRUE(back_end->anchored());
  EXPECT_FALSE(back_end->piece().valid());
  const Se3 T_began_anew(so3_exp({0, 0.4, 0}), {0.7, 0, 0.3});
  std::vector<Fragment> fragments = world.fragments();
  fragments[4].joined_to_previous = false;
  for (std::size_t f = 4; f < 7; ++f)
    fragments[f].T_odom_fragment = T_began_anew * fragments[f].T_odom_fragment;
  for (std::size_t f = 0; f < 6; ++f) {
    (void)grow(&*back_end, fragments[f]);
    EXPECT_EQ(back_end->anchored(), f < 4) << f;
    EXPECT_EQ(back_end->piece(), fragments[f < 4 ? 0 : 4].frames[0].frame) << f;
  }
  const Loop loop = world.loop(0, 0, 6);
  back_end->add_loops(Span<const Loop>(&loop, 1));
  EXPECT_TRUE(grow(&*back_end, fragments[6]));
  ASSERT_EQ(back_end->sifter().accepted().size(), 1U);
  EXPECT_TRUE(back_end->anchored());
  EXPECT_EQ(back_end->piece(), fragments[4].frames[0].frame);
  const std::vector<Se3> poses = back_end->T_map_fragment();
  for (std::size_t f = 4; f < 7; ++f)
    EXPECT_LT((poses[f].translation() - world.truth()[f].translation()).norm(), 0.06) << f;
  const Se3 corrected = back_end->T_map_odom() * fragments[6].T_odom_fragment;
  EXPECT_LT((corrected.translation() - world.truth()[6].translation()).norm(), 0.06);
}

TEST(BackEnd, LeavesOutWhatDoesNotFitAndGoesOn) {
  const FragmentWorld world;
  BackEndOptions options = small_back_end(true);
  options.posterior.max_fragments = options.proposal.max_fragments = 5;
  InArena<BackEnd> back_end(options);
  for (const Fragment& fragment : world.fragments()) (void)grow(&*back_end, fragment);
  back_end->finish();
  EXPECT_EQ(back_end->fragment_count(), 5);
  EXPECT_EQ(back_end->fragments_left_out(), 2);
  EXPECT_EQ(back_end->T_map_fragment().size(), 5U);
}

TEST(BackEnd, WithoutAnyFragmentEndsCleanly) {
  InArena<BackEnd> back_end(small_back_end(true));
  back_end->finish();
  EXPECT_TRUE(back_end->T_map_fragment().empty());
  EXPECT_EQ(back_end->dmp_odometry(), 0.0);
  EXPECT_EQ(back_end->dmp_final(), 0.0);
  const Loop loop = FragmentWorld().loop(0, 0, 6);
  back_end->add_loops(Span<const Loop>(&loop, 1));
  back_end->finish();
  EXPECT_EQ(back_end->sifter().records()[0].reason, Reason::kNoFragment);
}

TEST(BackEnd, OneFragmentIsAMap) {
  const FragmentWorld world;
  InArena<BackEnd> back_end(small_back_end(true));
  EXPECT_FALSE(grow(&*back_end, world.fragments()[0]));
  back_end->finish();
  ASSERT_EQ(back_end->T_map_fragment().size(), 1U);
  EXPECT_TRUE(back_end->proposals().empty());
}

TEST(BackEnd, CarvesWhatItMeasured) {
  const InArena<BackEnd> back_end(small_back_end(true));
  EXPECT_EQ(back_end.measured_bytes(), back_end.carved_bytes());
}

}  // namespace
}  // namespace loopsift
