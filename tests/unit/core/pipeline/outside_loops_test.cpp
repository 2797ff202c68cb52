// SPDX-License-Identifier: MIT
#include "core/pipeline/outside_loops.hpp"

#include <gtest/gtest.h>

#include "tests/support/fragment_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;

class Outside : public ::testing::Test {
 protected:
  Span<const Fragment> closed(std::size_t count) { return {world_.fragments().data(), count}; }
  const FragmentFrame& frame(std::size_t f, std::size_t k) { return world_.fragments()[f].frames[k]; }
  // What a detector says that sees frame k of fragment f and frame n of fragment g, T_Ff_Fg being the truth.
  OutsideLoop seen(std::size_t f, std::size_t k, std::size_t g, std::size_t n, const Se3& T_f_g) {
    OutsideLoop loop;
    loop.timestamp_i_ns = frame(f, k).timestamp_ns;
    loop.timestamp_j_ns = frame(g, n).timestamp_ns;
    loop.T_i_j = frame(f, k).T_fragment_camera.inverse() * T_f_g * frame(g, n).T_fragment_camera;
    loop.covariance = (Vector6d() << 1e-4, 2e-4, 3e-4, 1e-5, 2e-5, 3e-5).finished().asDiagonal();
    return loop;
  }
  FragmentWorld world_;
  OutsideLoops loops_;
  const Se3 T_ = Se3::exp((Vector6d() << 0.3, -0.1, 0.2, 0.1, 0.4, -0.2).finished());
};

TEST_F(Outside, TwoMomentsBecomeALoopBetweenTheirFragments) {
  loops_.add(seen(1, 2, 4, 3, T_));
  const std::vector<Loop> loops = loops_.resolve(closed(7));
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].i, world_.fragments()[1].id);
  EXPECT_EQ(loops[0].j, world_.fragments()[4].id);
  EXPECT_LT((loops[0].T_i_j.inverse() * T_).log().norm(), 1e-9);
  EXPECT_TRUE(loops_.resolve(closed(7)).empty()) << "once";
  EXPECT_EQ(loops_.left_out(), 0);
}

// To first order, an error of what was seen moves the fragments' loop by what the covariance was carried by.
TEST_F(Outside, TheCovarianceIsThatOfTheFragmentsLoopAlsoWhenTurnedRound) {
  for (const bool turned : {false, true}) {
    const OutsideLoop loop = turned ? seen(4, 3, 1, 2, T_) : seen(1, 2, 4, 3, T_);
    loops_.add(loop);
    const Loop clean = loops_.resolve(closed(7)).at(0);
    Matrix6d J;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 6; ++k) {
      OutsideLoop moved = loop;
      moved.T_i_j = loop.T_i_j * Se3::exp(kStep * Vector6d::Unit(k));
      loops_.add(moved);
      J.col(k) = (clean.T_i_j.inverse() * loops_.resolve(closed(7)).at(0).T_i_j).log() / kStep;
    }
    const Matrix6d expected = (J * loop.covariance * J.transpose()).inverse();
    EXPECT_TRUE(clean.information.isApprox(expected, 1e-4)) << "turned " << turned;
    EXPECT_LT(clean.i, clean.j);
  }
}

TEST_F(Outside, AMomentThatIsStillToComeIsWaitedFor) {
  loops_.add(seen(0, 1, 5, 0, T_));
  EXPECT_TRUE(loops_.resolve(closed(0)).empty());
  EXPECT_TRUE(loops_.resolve(closed(5)).empty());
  EXPECT_EQ(loops_.resolve(closed(6)).size(), 1U);
  EXPECT_EQ(loops_.left_out(), 0);
}

TEST_F(Outside, WhatFitsNoTwoFragmentsIsLeftOutAndCounted) {
  loops_.add(seen(2, 0, 2, 3, T_));
  EXPECT_TRUE(loops_.resolve(closed(7)).empty());
  EXPECT_EQ(loops_.left_out(), 1) << "both in one";
  OutsideLoop before = seen(1, 0, 4, 0, T_);
  before.timestamp_i_ns = frame(0, 0).timestamp_ns - 10'000'000'000;
  loops_.add(before);
  EXPECT_TRUE(loops_.resolve(closed(7)).empty());
  EXPECT_EQ(loops_.left_out(), 2) << "before the first frame";
}

TEST_F(Outside, TheOldestMakesRoom) {
  for (std::size_t k = 0; k < OutsideLoops::kWaiting + 5; ++k) loops_.add(seen(1, 2, 4, 3, T_));
  EXPECT_EQ(loops_.left_out(), 5);
  EXPECT_EQ(loops_.resolve(closed(7)).size(), OutsideLoops::kWaiting);
}

}  // namespace
}  // namespace loopsift
