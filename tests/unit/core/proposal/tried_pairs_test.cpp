// SPDX-License-Identifier: MIT
#include "core/proposal/tried_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/in_arena.hpp"

namespace loopsift {
namespace {

TEST(TriedPairs, KnowsHowFarAnEstimateHasMovedSince) {
  const test::InArena<TriedPairs> tried(4);
  const Se3 first(so3_exp({0.3, -0.2, 0.9}), {4, -1, 2});
  const Eigen::Vector3f center(1, 2, 3);
  tried->set(1, 3, first);
  EXPECT_NEAR(tried->moved(1, 3, first, center, 1.5F), 0.0F, 1e-3F);
  const Se3 shifted = Se3(Eigen::Matrix3d::Identity(), {0.0, 0.3, 0.4}) * first;
  EXPECT_NEAR(tried->moved(1, 3, shifted, center, 1.5F), 0.5F, 1e-3F);
  // A turn about the centre itself moves what lies around it.
  const Eigen::Matrix3d turn = so3_exp({0, 0, 0.1});
  const Eigen::Vector3d c = center.cast<double>();
  const Se3 turned = first * Se3(turn, c - turn * c);
  EXPECT_NEAR(tried->moved(1, 3, turned, center, 1.5F), 0.15F, 1e-3F);
}

TEST(TriedPairs, PairsAreKeptApart) {
  constexpr int kFragments = 5;
  const test::InArena<TriedPairs> tried(kFragments);
  for (std::size_t j = 1; j < kFragments; ++j)
    for (std::size_t i = 0; i < j; ++i) {
      EXPECT_TRUE(std::isinf(tried->moved(i, j, Se3(), Eigen::Vector3f::Zero(), 1))) << "never tried";
      tried->set(i, j, Se3(Eigen::Matrix3d::Identity(), {double(i), double(j), 0}));
    }
  for (std::size_t j = 1; j < kFragments; ++j)
    for (std::size_t i = 0; i < j; ++i)
      EXPECT_EQ(tried->moved(i, j, Se3(), Eigen::Vector3f::Zero(), 1), std::hypot(float(i), float(j)));
}

}  // namespace
}  // namespace loopsift
