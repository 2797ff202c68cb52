// SPDX-License-Identifier: MIT
// A camera that is pulled out and plugged in again ten times in a run: nothing mapped is lost, and nothing is
// invented about the way in between.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/steady_time.hpp"
#include "firmware_app/supervised_source.hpp"
#include "tests/fault/faulty_sequence.hpp"
#include "tests/support/fake_camera.hpp"

namespace loopsift {
namespace {

constexpr int kUnplugs = 10;
constexpr int kFramesBetween = 8;
constexpr int kFramesMissed = 8;  // while the camera is away it is carried on
constexpr int kTries = 3;         // until it is open again
constexpr std::int64_t kLimit_ns = 60'000'000'000;

TEST(Unplug, TenTimesInARunNothingMappedIsLost) {
  test::FaultySequence run;
  RawFrame rendered = run.frame(0);
  test::Cable cable;
  cable.info.camera = {rendered.depth.width, rendered.depth.height, 262.5F, 262.5F, 159.5F, 119.5F};
  cable.info.live = true;
  cable.frames_after = kFramesBetween;
  int k = 0;
  cable.draw = [&](RawFrame* frame) {
    if (frame->sequence == 0 && k > 0) k += kFramesMissed;  // the first of an opening
    rendered = run.frame(k++);
    std::copy_n(rendered.depth.data, rendered.depth.size(), frame->depth_buffer.data());
  };
  RetryOptions options;
  options.retry_first_ms = options.retry_max_ms = 1;
  const auto open = [&] {
    if (cable.tried % kTries == 1) cable.refusals = kTries - 1;  // after each success
    return test::FakeCamera::open(cable);
  };
  SupervisedSource source(std::move(*open()), open, options);
  source.start();

  std::vector<std::uint16_t> depth(rendered.depth.size());
  RawFrame frame;
  frame.depth_buffer = {depth.data(), depth.size()};
  int tracked = 0, pieces = 0;
  const std::int64_t until = steady_now_ns() + kLimit_ns;
  while (tracked < (kUnplugs + 1) * kFramesBetween && steady_now_ns() < until) {
    if (source.read(frame, 5) != ReadStatus::kFrame) continue;
    const FrontEndResult result = run.front_end().process(frame);
    ASSERT_NE(result.tracking.status, TrackingStatus::kLost) << k;
    ++tracked;
    if (result.tracking.status == TrackingStatus::kFirst) ++pieces;
    EXPECT_EQ(result.tracking.status == TrackingStatus::kFirst, (tracked - 1) % kFramesBetween == 0)
        << tracked;
  }
  (void)run.front_end().finish();
  EXPECT_EQ(source.returns(), kUnplugs);
  EXPECT_EQ(cable.tried, 1 + kTries * kUnplugs);
  EXPECT_EQ(pieces, kUnplugs + 1);
  ASSERT_EQ(run.store().fragments().size(), static_cast<std::size_t>(kUnplugs + 1));
  for (const Fragment& fragment : run.store().fragments()) {
    EXPECT_FALSE(fragment.joined_to_previous) << "nobody saw the way here";
    EXPECT_EQ(fragment.frames.size(), static_cast<std::size_t>(kFramesBetween));
    EXPECT_GT(fragment.surfels.size(), 1000U);
  }
}

}  // namespace
}  // namespace loopsift
