// SPDX-License-Identifier: MIT
// What a camera does when it does not do its best: the front end must say so, invent nothing and go on.
#include <gtest/gtest.h>

#include "tests/fault/faulty_sequence.hpp"

namespace loopsift {
namespace {

using test::FaultySequence;

constexpr double kWellM = 0.05;  // of a pose that a short fault did not disturb

class FrontEndFault : public testing::Test {
 protected:
  FaultySequence run_;
};

TEST_F(FrontEndFault, FramesWithoutAnyDepthAreLostAndTheNextGoodOneGoesOn) {
  run_.track(0, 20);
  int k = 20;
  for (const int value : {0, 65535, 60000}) {  // nothing, saturated, beyond all range
    RawFrame raw = run_.frame(k++);
    run_.fill_depth(static_cast<std::uint16_t>(value));
    const FrontEndResult result = run_.see(raw);
    EXPECT_EQ(result.tracking.status, TrackingStatus::kLost);
    EXPECT_EQ(result.tracking.reason, LostReason::kNoDepth) << value;
    EXPECT_TRUE(result.tracking.information.isZero(0.0)) << "nothing is known of a lost frame";
    EXPECT_EQ(result.closed, nullptr);
  }
  for (; k < 40; ++k) {
    const FrontEndResult result = run_.see(k);
    ASSERT_EQ(result.tracking.status, TrackingStatus::kTracked) << k;
    EXPECT_LT(run_.error_m(k, result.tracking.T_odom_camera), kWellM) << k;
  }
}

TEST_F(FrontEndFault, HolesInHalfOfTheImageAreNoLoss) {
  run_.track(0, 20);
  for (int k = 20; k < 30; ++k) {
    const RawFrame raw = run_.frame(k);
    for (int y = 0; y < raw.depth.height; ++y)
      std::fill_n(raw.depth.row(y) + (k % 2 == 0 ? 0 : raw.depth.width / 2), raw.depth.width / 2,
                  std::uint16_t{0});
    const FrontEndResult result = run_.see(raw);
    ASSERT_EQ(result.tracking.status, TrackingStatus::kTracked) << k;
    EXPECT_LT(run_.error_m(k, result.tracking.T_odom_camera), kWellM) << k;
  }
}

TEST_F(FrontEndFault, DuplicatedAndBackwardTimeStampsAreRefused) {
  run_.track(0, 20);
  const std::int64_t last_ns = run_.frame(19).timestamp_ns;
  for (const std::int64_t time_ns : {last_ns, last_ns - 500000000}) {
    RawFrame raw = run_.frame(20);
    raw.timestamp_ns = time_ns;
    const FrontEndResult result = run_.see(raw);
    EXPECT_EQ(result.tracking.status, TrackingStatus::kLost);
    EXPECT_EQ(result.tracking.reason, LostReason::kBadTime);
  }
  for (int k = 20; k < 35; ++k) {
    const FrontEndResult result = run_.see(k);
    ASSERT_EQ(result.tracking.status, TrackingStatus::kTracked) << k;
    EXPECT_LT(run_.error_m(k, result.tracking.T_odom_camera), kWellM) << k;
  }
}

TEST_F(FrontEndFault, AClockSetBackForGoodStartsANewPiece) {
  run_.track(0, 20);
  bool started = false;
  for (int k = 20; k < 35; ++k) {
    RawFrame raw = run_.frame(k);
    raw.timestamp_ns -= 100000000000;
    const FrontEndResult result = run_.see(raw);
    if (result.tracking.status == TrackingStatus::kFirst) started = true;
    EXPECT_NE(result.tracking.status, started ? TrackingStatus::kLost : TrackingStatus::kTracked) << k;
  }
  EXPECT_TRUE(started);
}

// A second without frames: either the pose is right, or none is given and a piece of its own begins.
TEST_F(FrontEndFault, AfterABurstOfDroppedFramesNoPoseIsInvented) {
  for (const int gap : {30, 60}) {
    FaultySequence run;
    run.track(0, 40);
    for (int k = 40 + gap; k < 40 + gap + 30; ++k) {
      const FrontEndResult result = run.see(k);
      if (result.tracking.status == TrackingStatus::kLost) continue;
      EXPECT_LT(run.error_m(k, result.tracking.T_odom_camera), kWellM) << "gap " << gap << " frame " << k;
    }
  }
}

TEST_F(FrontEndFault, ColourMayGoMissingAndComeBack) {
  for (int k = 0; k < 60; ++k) {
    RawFrame raw = run_.frame(k);
    if (k >= 20 && k < 40) raw.color = {};
    const FrontEndResult result = run_.see(raw);
    ASSERT_NE(result.tracking.status, TrackingStatus::kLost) << k;
    EXPECT_LT(run_.error_m(k, result.tracking.T_odom_camera), kWellM) << k;
    if (k > 21) {
      EXPECT_EQ(result.tracking.keyframe_overlap > 0, k > 40) << k;
    }
  }
}

TEST_F(FrontEndFault, ExposureFlashesDoNotMoveThePose) {
  for (int k = 0; k < 60; ++k) {
    const RawFrame raw = run_.frame(k);
    if (k % 7 == 3) run_.brighten(k % 2 == 0 ? 4.0 : 0.1);
    const FrontEndResult result = run_.see(raw);
    ASSERT_NE(result.tracking.status, TrackingStatus::kLost) << k;
    EXPECT_LT(run_.error_m(k, result.tracking.T_odom_camera), kWellM) << k;
  }
}

TEST_F(FrontEndFault, ACoveredLensIsLostAtOnceAndWhatWasMappedStays) {
  run_.track(0, 40);
  for (int k = 40; k < 100; ++k) {
    const RawFrame raw = run_.frame(k);
    run_.fill_depth(0);
    run_.brighten(0);
    const FrontEndResult result = run_.see(raw);
    ASSERT_EQ(result.tracking.reason, LostReason::kNoDepth) << k;
  }
  const FrontEndResult again = run_.see(100);
  EXPECT_EQ(again.tracking.status, TrackingStatus::kFirst);
  ASSERT_NE(again.closed, nullptr);
  EXPECT_EQ(again.closed->frames.size(), 10U) << "frames 30 to 39 are kept";
  run_.track(101, 130);
  (void)run_.front_end().finish();
  ASSERT_EQ(run_.store().fragments().size(), 3U);
  const Fragment& after = run_.store().fragments()[2];
  EXPECT_FALSE(after.joined_to_previous) << "it hangs on no odometry edge";
  EXPECT_TRUE(run_.store().fragments()[1].joined_to_previous);
}

}  // namespace
}  // namespace loopsift
