// SPDX-License-Identifier: MIT
#include "core/geometry/brown_conrady.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

// Of the size that Kinect-class lenses have.
BrownConrady kinect_like() {
  BrownConrady lens;
  lens.k1 = 0.2645;
  lens.k2 = -0.8399;
  lens.k3 = 0.9119;
  lens.p1 = -0.00199;
  lens.p2 = 0.00144;
  return lens;
}

TEST(BrownConrady, WithoutCoefficientsNothingMoves) {
  const BrownConrady lens;
  EXPECT_TRUE(lens.is_identity());
  EXPECT_EQ(lens.distort({0.3, -0.2}), Eigen::Vector2d(0.3, -0.2));
  Eigen::Vector2d ideal;
  ASSERT_TRUE(lens.undistort({0.3, -0.2}, &ideal));
  EXPECT_EQ(ideal, Eigen::Vector2d(0.3, -0.2));
}

TEST(BrownConrady, EachCoefficientDoesWhatItsTermSays) {
  // At (0.5, 0.25): r² = 0.3125, r⁴ = 0.09765625, r⁶ = 0.030517578125.
  const Eigen::Vector2d at(0.5, 0.25);
  const auto moved = [&](double BrownConrady::*coefficient) {
    BrownConrady lens;
    lens.*coefficient = 0.1;
    return Eigen::Vector2d(lens.distort(at) - at);
  };
  EXPECT_TRUE(moved(&BrownConrady::k1).isApprox(0.03125 * at, 1e-12));
  EXPECT_TRUE(moved(&BrownConrady::k2).isApprox(0.009765625 * at, 1e-12));
  EXPECT_TRUE(moved(&BrownConrady::k3).isApprox(0.0030517578125 * at, 1e-12));
  EXPECT_TRUE(moved(&BrownConrady::p1).isApprox(Eigen::Vector2d(0.2 * 0.125, 0.1 * (0.3125 + 0.125)), 1e-12));
  EXPECT_TRUE(moved(&BrownConrady::p2).isApprox(Eigen::Vector2d(0.1 * (0.3125 + 0.5), 0.2 * 0.125), 1e-12));
}

TEST(BrownConrady, TheJacobianIsThatOfTheFunction) {
  const BrownConrady lens = kinect_like();
  constexpr double kStep = 1e-6;
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.1, -0.3), Eigen::Vector2d(-0.5, 0.4)}) {
    Eigen::Matrix2d numeric;
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
      numeric.col(i) = (lens.distort(at + step) - lens.distort(at - step)) / (2 * kStep);
    }
    EXPECT_TRUE(lens.jacobian(at).isApprox(numeric, 1e-8)) << lens.jacobian(at) << "\n" << numeric;
  }
}

TEST(BrownConrady, UndistortIsTheInverseOverAWholeImage) {
  const BrownConrady lens = kinect_like();
  for (double x = -0.6; x <= 0.6; x += 0.1) {
    for (double y = -0.45; y <= 0.45; y += 0.1) {
      Eigen::Vector2d ideal;
      ASSERT_TRUE(lens.undistort(lens.distort({x, y}), &ideal)) << x << " " << y;
      EXPECT_NEAR(ideal.x(), x, 1e-8);
      EXPECT_NEAR(ideal.y(), y, 1e-8);
    }
  }
}

TEST(BrownConrady, WhatAFoldedLensNeverReachesIsNotInvented) {
  BrownConrady lens;
  lens.k1 = -1;  // x (1 − x²) is at most 0.385
  Eigen::Vector2d ideal;
  EXPECT_FALSE(lens.undistort({0.6, 0.0}, &ideal));
  EXPECT_TRUE(lens.undistort({0.3, 0.0}, &ideal));
}

}  // namespace
}  // namespace loopsift
