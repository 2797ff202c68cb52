// SPDX-License-Identifier: MIT
#include "core/sifter/challenge.hpp"

#include <gtest/gtest.h>

#include "tests/unit/core/sifter/sifting.hpp"

namespace loopsift {
namespace {

using test::error;
using test::FragmentWorld;
using test::Sifting;

TEST(Challengers, MoveTheCentreByTheStepOrTurnAboutIt) {
  const Se3 T_i_j(so3_exp({0.2, -0.3, 0.1}), {1, 2, 3});
  const Eigen::Vector3d centroid(0.5, -0.2, 2.0);
  const std::vector<Se3> motions = challengers(T_i_j, {0.3, 0.05}, centroid);
  ASSERT_EQ(motions.size(), 20U);
  int moved = 0, turned = 0;
  Eigen::Vector3d shifts = Eigen::Vector3d::Zero(), turns = Eigen::Vector3d::Zero();
  for (const Se3& T : motions) {
    const Se3 step = T_i_j.inverse() * T;  // in fragment j
    const Eigen::Vector3d shift = step * centroid - centroid;
    if (step.angle() < 1e-9) {
      EXPECT_NEAR(shift.norm(), 0.3, 1e-9);
      shifts += shift;
      ++moved;
    } else {
      EXPECT_NEAR(step.angle(), 0.05, 1e-9);
      EXPECT_LT(shift.norm(), 1e-9);
      turns += so3_log(step.rotation());
      ++turned;
    }
  }
  EXPECT_EQ(moved, 14);
  EXPECT_EQ(turned, 6);
  EXPECT_LT(shifts.norm(), 1e-9) << "each both ways";
  EXPECT_LT(turns.norm(), 1e-9) << "each both ways";
  for (std::size_t a = 0; a < motions.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_GT((motions[a].inverse() * motions[b]).log().norm(), 1e-3) << a << " and " << b;
}

TEST(ChallengeStep, OfTheCorrectionIsHowFarTheLoopMovesTheFragment) {
  const Se3 map(so3_exp({0, 0.5, 0}), {1, 0, 2});
  const Eigen::Vector3d centroid(0.3, 0.1, 1.5);
  const ChallengeStep none = correction_step(map, map, centroid);
  EXPECT_NEAR(none.distance_m, 0, 1e-12);
  EXPECT_NEAR(none.angle_rad, 0, 1e-7);
  const Se3 shift(Eigen::Matrix3d::Identity(), {0.3, 0, 0.4});
  EXPECT_NEAR(correction_step(map * shift, map, centroid).distance_m, 0.5, 1e-12);
  const Eigen::Matrix3d R = so3_exp({0, 0.2, 0});
  const ChallengeStep turn = correction_step(map * Se3(R, centroid - R * centroid), map, centroid);
  EXPECT_NEAR(turn.distance_m, 0, 1e-12);
  EXPECT_NEAR(turn.angle_rad, 0.2, 1e-9);
}

TEST(ChallengeStep, OfTheImageGrowsWithTheMeasuredDepth) {
  const FragmentWorld world;
  const Sifting sifting(world);
  const ChallengeStep step = image_step(*sifting.scorer);
  EXPECT_GT(sifting.scorer->typical_depth(), 1.0);  // the room is 4.2 m × 5 m
  EXPECT_LT(sifting.scorer->typical_depth(), 4.0);
  EXPECT_NEAR(step.distance_m / sifting.scorer->typical_depth(), step.angle_rad, 1e-12);
}

TEST(Challenge, TrueLoopsWithstandAndNearMissesDoNot) {
  const FragmentWorld world;
  const Sifting sifting(world);
  for (const Loop& loop : test::true_loops(world))
    EXPECT_TRUE(withstands_challenge(*sifting.scorer, loop, world.odometry(), true)) << loop.id.value;
  for (const Vector6d& e : {error(0.35, 0, 0, 0), error(0, 0, -0.3, 0), error(0.25, 0.2, 0, 0.1)})
    EXPECT_FALSE(withstands_challenge(*sifting.scorer, world.loop(10, 0, 6, e), world.odometry(), true))
        << e.transpose();
}

// Off by a shift and a turn together, of which neither alone makes it better by a whole step.
TEST(Challenge, ADescentLeadsAwayFromANearMissAndNotFromATrueLoop) {
  const FragmentWorld world;
  const Sifting sifting(world);
  for (const Loop& loop : test::true_loops(world))
    EXPECT_TRUE(is_at_its_best(*sifting.scorer, loop)) << loop.id.value;
  for (const Vector6d& e : {error(0.2, 0, -0.15, 0.12), error(-0.2, 0.05, 0.15, -0.12), error(0, 0, 0.3, 0)})
    EXPECT_FALSE(is_at_its_best(*sifting.scorer, world.loop(10, 0, 6, e))) << e.transpose();
}

TEST(Challenge, ALoopThatSharesNoPixelIsNotBelieved) {
  const FragmentWorld world;
  const Sifting sifting(world);
  EXPECT_FALSE(withstands_challenge(*sifting.scorer, world.loop(10, 0, 6, error(50, 0, 0, 0)),
                                    world.odometry(), true));
}

// Where a piece lies that hangs on nothing is nobody's estimate: how far a loop moves it tells nothing.
TEST(Challenge, OfAPieceThatHangsOnNothingTheWayThatItMovesDoesNotMatter) {
  const FragmentWorld world;
  const Sifting sifting(world);
  std::vector<Se3> elsewhere = world.odometry();
  elsewhere[6] = Se3(so3_exp({0, 0.4, 0}), {0.7, 0, 0.3}) * elsewhere[6];
  const Loop loop = world.loop(0, 0, 6), near_miss = world.loop(1, 0, 6, error(0.35, 0, 0, 0));
  EXPECT_FALSE(withstands_challenge(*sifting.scorer, loop, elsewhere, true))
      << "its far neighbours are asked";
  EXPECT_TRUE(withstands_challenge(*sifting.scorer, loop, elsewhere, false));
  EXPECT_FALSE(withstands_challenge(*sifting.scorer, near_miss, elsewhere, false));
}

}  // namespace
}  // namespace loopsift
