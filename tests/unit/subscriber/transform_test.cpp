// SPDX-License-Identifier: MIT
#include "loopsift/client/transform.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace loopsift::client {
namespace {

constexpr double kPi = 3.14159265358979323846;

Transform turned(double yaw, Vector3 trans = {}) {
  return {trans, {std::cos(yaw / 2), 0, 0, std::sin(yaw / 2)}};
}

TEST(Transform, ComposesAndInverts) {
  const Transform T = turned(kPi / 2, {1, 2, 3});
  const Vector3 p = T * Vector3{1, 0, 0};
  EXPECT_NEAR(p[0], 1, 1e-12);
  EXPECT_NEAR(p[1], 3, 1e-12);
  EXPECT_NEAR(p[2], 3, 1e-12);
  const Transform same = T * T.inverse();
  EXPECT_NEAR(same.trans[0], 0, 1e-12);
  EXPECT_NEAR(same.trans[1], 0, 1e-12);
  EXPECT_NEAR(std::abs(same.quat[0]), 1, 1e-12);
  EXPECT_NEAR((T * turned(0.2)).yaw(), kPi / 2 + 0.2, 1e-12);
}

TEST(Transform, InterpolatesTheShorterWayRound) {
  const Transform a = turned(0.2, {0, 0, 0});
  Transform b = turned(0.6, {2, 0, 4});
  for (double& q : b.quat) q = -q;  // the same rotation
  const Transform middle = interpolate(a, b, 0.25);
  EXPECT_NEAR(middle.yaw(), 0.3, 1e-12);
  EXPECT_NEAR(middle.trans[2], 1, 1e-12);
  EXPECT_NEAR(interpolate(a, a, 0.5).yaw(), 0.2, 1e-12);
}

TEST(Transform, KnowsNonsense) {
  EXPECT_TRUE(is_valid(turned(1)));
  EXPECT_FALSE(is_valid({{0, 0, 0}, {0, 0, 0, 0}}));
  EXPECT_FALSE(is_valid({{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {1, 0, 0, 0}}));
  EXPECT_FALSE(is_valid({{0, 0, 0}, {std::numeric_limits<double>::infinity(), 0, 0, 0}}));
}

}  // namespace
}  // namespace loopsift::client
