// SPDX-License-Identifier: MIT
#include "core/odometry/stream_odometry.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace loopsift {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kStart = 50'000 * kMs;

Se3 at(double x_m) { return {Eigen::Matrix3d::Identity(), {x_m, 0, 0}}; }

class Stream : public ::testing::Test {
 protected:
  static StreamOdometryOptions options() {
    StreamOdometryOptions made;
    made.wait_ms = 0;
    return made;
  }
  // 1 m/s along x, a pose every 10 ms.
  void push(int first, int last) {
    for (int k = first; k <= last; ++k) odometry_.push(kStart + k * 10 * kMs, at(0.01 * k));
  }
  TrackingResult track(std::int64_t after_start_ms) {
    return odometry_.track(FrameId{0}, kStart + after_start_ms * kMs);
  }
  StreamOdometry odometry_{options()};
};

TEST_F(Stream, InterpolatesBetweenThePosesAboutAFrame) {
  push(0, 20);
  EXPECT_EQ(track(35).status, TrackingStatus::kFirst);
  const TrackingResult later = track(68);
  EXPECT_EQ(later.status, TrackingStatus::kTracked);
  EXPECT_NEAR(later.T_odom_camera.translation().x(), 0.068, 1e-9);
  EXPECT_GT(later.information(0, 0), 0);
  EXPECT_NEAR(track(200).T_odom_camera.translation().x(), 0.2, 1e-9) << "the newest pose itself";
}

TEST_F(Stream, WithoutAPoseOnBothSidesNoneIsInvented) {
  push(10, 20);
  EXPECT_EQ(track(50).reason, LostReason::kNoPose) << "before the first";
  EXPECT_EQ(track(205).reason, LostReason::kNoPose) << "after the newest";
  push(40, 41);
  EXPECT_EQ(track(300).reason, LostReason::kNoPose) << "in a gap of 0.2 s";
  EXPECT_EQ(odometry_.counts().missing, 3);
  EXPECT_EQ(track(405).status, TrackingStatus::kFirst);
}

TEST_F(Stream, RepeatedAndLatePosesAreLeftOutAndCounted) {
  push(0, 10);
  push(10, 10);
  odometry_.push(kStart + 55 * kMs, at(99));
  EXPECT_NEAR(track(57).T_odom_camera.translation().x(), 0.057, 1e-9);
  EXPECT_EQ(odometry_.counts().late, 2);
  EXPECT_EQ(odometry_.counts().taken, 11);
}

TEST_F(Stream, AJumpStartsANewPiece) {
  push(0, 10);
  EXPECT_EQ(track(80).status, TrackingStatus::kFirst);
  EXPECT_EQ(track(90).status, TrackingStatus::kTracked);
  for (int k = 11; k < 15; ++k) odometry_.push(kStart + k * 10 * kMs, at(5 + 0.01 * k));
  const TrackingResult after = track(115);
  EXPECT_EQ(after.status, TrackingStatus::kFirst) << "nothing is known of the way there";
  EXPECT_NEAR(after.T_odom_camera.translation().x(), 5.115, 1e-9);
  EXPECT_EQ(track(125).status, TrackingStatus::kTracked);
  EXPECT_EQ(odometry_.counts().jumps, 1);
}

TEST_F(Stream, AClockSetBackStartsANewPiece) {
  push(0, 10);
  EXPECT_EQ(track(80).status, TrackingStatus::kFirst);
  for (int k = 0; k < 5; ++k) odometry_.push(1000 * kMs + k * 10 * kMs, at(0.01 * k));
  EXPECT_EQ(odometry_.track(FrameId{0}, 1015 * kMs).status, TrackingStatus::kFirst);
  EXPECT_EQ(odometry_.counts().restarts, 1);
}

TEST_F(Stream, PosesThatNobodyTakesAreRefusedAndTheStreamRecovers) {
  push(0, static_cast<int>(StreamOdometry::kWaiting) + 99);
  EXPECT_EQ(odometry_.counts().refused, 100);
  EXPECT_EQ(track(10).status, TrackingStatus::kLost) << "older than what is kept";
  push(2000, 2001);
  EXPECT_EQ(track(20'005).status, TrackingStatus::kFirst);
}

TEST(StreamOdometry, AFrameWaitsForThePoseThatIsOnItsWay) {
  StreamOdometryOptions options;
  options.wait_ms = 60'000;  // ends as soon as the pose is there
  StreamOdometry odometry(options);
  odometry.push(kStart, at(0));
  std::thread sender([&] { odometry.push(kStart + 20 * kMs, at(0.02)); });
  const TrackingResult result = odometry.track(FrameId{0}, kStart + 10 * kMs);
  sender.join();
  EXPECT_EQ(result.status, TrackingStatus::kFirst);
  EXPECT_NEAR(result.T_odom_camera.translation().x(), 0.01, 1e-9);
}

}  // namespace
}  // namespace loopsift
