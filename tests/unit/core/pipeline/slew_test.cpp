// SPDX-License-Identifier: MIT
#include "core/pipeline/slew.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

const Se3 kCorrection = Se3::exp((Vector6d() << 0.3, -0.1, 0.2, 0.02, 0.1, -0.05).finished());
const Se3 kFarAway = Se3::exp((Vector6d() << 20, 3, -11, 0.4, 1.1, 0.2).finished());

double distance_m(const Se3& a, const Se3& b) { return (a.inverse() * b).translation().norm(); }

TEST(Slew, OffByDefaultTheCorrectionIsShownAtOnce) {
  Slew slew{SlewOptions{}};
  EXPECT_EQ(slew.follow(kCorrection, kFarAway, 0.0).matrix(), kCorrection.matrix());
}

// Far from the map's origin a turn of the correction moves the camera most; that is what is bounded.
TEST(Slew, TheCameraMovesNoFasterThanTheLimitsAndArrives) {
  const SlewOptions options{0.2, 0.05};
  Slew slew(options);
  const double dt_s = 0.1;
  Se3 before = kFarAway;
  int steps = 0;
  for (; steps < 1000; ++steps) {
    const Se3 after = slew.follow(kCorrection, kFarAway, dt_s) * kFarAway;
    const Se3 moved = before.inverse() * after;
    EXPECT_LE(moved.translation().norm(), options.max_m_per_s * dt_s * (1 + 1e-6));
    EXPECT_LE(moved.angle(), options.max_rad_per_s * dt_s * (1 + 1e-6));
    before = after;
    if (distance_m(after, kCorrection * kFarAway) < 1e-9) break;
  }
  EXPECT_GT(steps, 5);
  EXPECT_LT(steps, 1000);
  EXPECT_EQ(slew.follow(kCorrection, kFarAway, dt_s).matrix(), kCorrection.matrix());
}

TEST(Slew, WithoutTimeItStandsStill) {
  Slew slew(SlewOptions{0.2, 0.0});
  for (const double dt_s : {0.0, -1.0})
    EXPECT_LT(distance_m(slew.follow(kCorrection, kFarAway, dt_s), Se3()), 1e-9);
}

TEST(Slew, OneLimitMayBeLeftOut) {
  Slew slew(SlewOptions{0.0, 0.05});
  const Se3 first = slew.follow(kCorrection, Se3(), 0.1);
  EXPECT_NEAR(first.angle(), 0.005, 1e-6);
}

}  // namespace
}  // namespace loopsift
