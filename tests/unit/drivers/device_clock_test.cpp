// SPDX-License-Identifier: MIT
#include "drivers/device_clock.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod = 33 * kMs;
constexpr std::int64_t kBoot = 5'000'000 * kMs;  // host time at which the device's clock starts

std::int64_t mapped(DeviceClock& clock, std::int64_t device_ns, std::int64_t arrival_ns) {
  std::int64_t host_ns = -1;
  EXPECT_TRUE(clock.map(device_ns, arrival_ns, &host_ns));
  return host_ns;
}

TEST(DeviceClock, LateArrivalsDoNotShiftTheTimes) {
  DeviceClock clock;
  const std::int64_t first = mapped(clock, kPeriod, kBoot + kPeriod);
  EXPECT_EQ(first, kBoot + kPeriod);
  for (int k = 2; k < 200; ++k) {
    const std::int64_t delay = k % 7 == 0 ? 20 * kMs : k % 3 * kMs;
    const std::int64_t host = mapped(clock, k * kPeriod, kBoot + k * kPeriod + delay);
    EXPECT_NEAR(static_cast<double>(host - kBoot - k * kPeriod), 0, 1e5) << k;  // what drift is allowed
  }
}

TEST(DeviceClock, ADelayedFirstFrameIsMadeGoodWithoutGoingBack) {
  DeviceClock clock;
  std::int64_t last = mapped(clock, kPeriod, kBoot + kPeriod + 100 * kMs);
  for (int k = 2; k < 20; ++k) {
    const std::int64_t host = mapped(clock, k * kPeriod, kBoot + k * kPeriod);
    EXPECT_GE(host - last, kPeriod / 2) << k;
    last = host;
  }
  EXPECT_EQ(last, kBoot + 19 * kPeriod);
}

TEST(DeviceClock, FollowsAClockThatRunsSlow) {
  DeviceClock clock;
  constexpr double kSlow = 1 - 1e-4;
  std::int64_t host = 0, arrival = 0;
  for (int k = 1; k < 20'000; ++k) {
    arrival = kBoot + k * kPeriod;
    host = mapped(clock, static_cast<std::int64_t>(kSlow * static_cast<double>(k * kPeriod)), arrival);
  }
  EXPECT_LE(arrival - host, kMs);  // 660 s later the clocks are 66 ms apart
}

TEST(DeviceClock, AJumpStartsAnew) {
  for (const std::int64_t jump : {std::int64_t{-3'000'000} * kMs, std::int64_t{9'000'000'000} * kMs}) {
    DeviceClock clock;
    const std::int64_t device = 4'000'000 * kMs;
    const std::int64_t before = mapped(clock, device, kBoot);
    const std::int64_t after = mapped(clock, device + jump + kPeriod, kBoot + kPeriod);
    EXPECT_EQ(after - before, kPeriod);
    EXPECT_EQ(mapped(clock, device + jump + 2 * kPeriod, kBoot + 2 * kPeriod), after + kPeriod);
  }
}

TEST(DeviceClock, AStandStillOrASmallStepBackIsRefused) {
  DeviceClock clock;
  (void)mapped(clock, 10 * kPeriod, kBoot);
  std::int64_t host = -1;
  EXPECT_FALSE(clock.map(10 * kPeriod, kBoot + kPeriod, &host));
  EXPECT_FALSE(clock.map(9 * kPeriod, kBoot + 2 * kPeriod, &host));
  EXPECT_EQ(mapped(clock, 13 * kPeriod, kBoot + 3 * kPeriod), kBoot + 3 * kPeriod);
}

TEST(DeviceClock, WithoutDeviceTimesArrivalsCountAndStillIncrease) {
  DeviceClock clock;
  EXPECT_EQ(mapped(clock, 0, kBoot), kBoot);
  EXPECT_EQ(mapped(clock, 0, kBoot), kBoot + 1);
  EXPECT_EQ(mapped(clock, 0, kBoot + kPeriod), kBoot + kPeriod);
}

}  // namespace
}  // namespace loopsift
