// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/bus/health_screen.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

health_t tracking() {
  health_t health{};
  health.state = health_t::TRACKING;
  health.uptime_s = 12;
  health.anchored = 1;
  health.frames_tracked = 345;
  health.temperature_c = health.clock_mhz = std::numeric_limits<float>::quiet_NaN();
  health.fence_peak_bytes = -1;
  health.n_latency = 2;
  health.latency[0] = {"odometry", 345, 4.5F, 9.25F, 11};
  health.latency[1].stage = "proposal";
  health.n_threads = 1;
  health.threads[0] = {"front", 3, -1, 0, 0};
  health.n_pools = 1;
  health.pools[0] = {"store/fragments", 360, 360, 7};
  return health;
}

TEST(HealthScreen, SaysWhatIsKnownAndLeavesOutWhatIsNot) {
  const std::string text = health_screen(tracking(), 0.1);
  EXPECT_THAT(text, HasSubstr("loopsift: tracking, up 12 s\n"));
  EXPECT_THAT(text, HasSubstr("345 tracked"));
  EXPECT_THAT(text, HasSubstr("9.25"));
  EXPECT_THAT(text, Not(HasSubstr("proposal"))) << "nothing was timed";
  EXPECT_THAT(text, Not(HasSubstr("°C")));
  EXPECT_THAT(text, Not(HasSubstr("back thread's heap")));
  EXPECT_THAT(text, HasSubstr("FULL"));
}

TEST(HealthScreen, SaysWhyTrackingWasLostAndThatThePoseInTheMapIsNotKnown) {
  EXPECT_THAT(health_screen(tracking(), 0), Not(HasSubstr("NOT JOINED")));
  health_t health = tracking();
  health.state = health_t::LOST;
  health.lost_reason = health_t::NO_DEPTH;
  health.anchored = 0;
  EXPECT_THAT(health_screen(health, 0), HasSubstr("lost (too little depth), NOT JOINED to the map"));
}

TEST(HealthScreen, ASilentProgramIsNotTakenForATrackingOne) {
  EXPECT_THAT(health_screen(tracking(), 5), HasSubstr("SILENT for 5 s"));
}

TEST(HealthScreen, CountsAndStatesOutOfRangeAreHarmless) {
  health_t health = tracking();
  health.n_pools = 1000;
  health.n_latency = -4;
  health.state = 99;
  EXPECT_THAT(health_screen(health, 0), HasSubstr("loopsift: ?"));
}

}  // namespace
}  // namespace loopsift::tool
