// SPDX-License-Identifier: MIT
#include "drivers/live_stamps.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(FrameCounter, CountsOnThroughAWrap) {
  FrameCounter counter;
  EXPECT_EQ(counter.next(0xFFFFFFFE), 0);
  EXPECT_EQ(counter.next(0xFFFFFFFF), 1);
  EXPECT_EQ(counter.next(1), 3);  // 0 is missing
}

TEST(FrameCounter, ADeviceThatDoesNotCountIsCounted) {
  FrameCounter counter;
  for (std::int64_t k = 0; k < 5; ++k) EXPECT_EQ(counter.next(0), k);
}

TEST(LiveClock, OwnTimesAreKept) {
  LiveClock clock;
  EXPECT_EQ(clock.stamp(100 * kSecond, 101 * kSecond), 100 * kSecond);
  EXPECT_EQ(clock.stamp(101 * kSecond, 101 * kSecond), 101 * kSecond);
  EXPECT_EQ(clock.replaced(), 0);
}

TEST(LiveClock, ATimeOfAnotherClockIsReplaced) {
  LiveClock clock;
  EXPECT_EQ(clock.stamp(5 * kSecond, 100 * kSecond), 100 * kSecond);  // since the device was started
  EXPECT_EQ(clock.stamp(1'700'000'000 * kSecond, 101 * kSecond), 101 * kSecond);  // the wall clock
  EXPECT_EQ(clock.replaced(), 2);
}

TEST(LiveClock, OneStepBackIsForgivenByTheNextForward) {
  LiveClock clock;
  EXPECT_GT(clock.stamp(100 * kSecond, 101 * kSecond), 0);
  for (int round = 1; round < 3 * LiveClock::kMostBackward; ++round) {
    EXPECT_EQ(clock.stamp(99 * kSecond, 101 * kSecond), -1);
    EXPECT_EQ(clock.stamp(100 * kSecond + round, 101 * kSecond), 100 * kSecond + round);
  }
}

}  // namespace
}  // namespace loopsift
