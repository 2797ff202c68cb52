// SPDX-License-Identifier: MIT
// A recorded Kinect sequence, where there is one.
#include <gtest/gtest.h>

#include <cstdlib>

#include "drivers/replay/replay_source.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift {
namespace {

TEST(RealData, RedkitchenReadsWithPlausibleDepthAndColor) {
  const char* data = std::getenv("LOOPSIFT_DATA");
  if (data == nullptr) GTEST_SKIP() << "LOOPSIFT_DATA is not set: no recorded sequence to read";
  auto source = open_replay("7scenes", std::string(data) + "/redkitchen", {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().frame_count, 1000);
  EXPECT_EQ((*source)->info().camera.fx, 585);
  test::FrameBuffers buffers((*source)->info());
  for (int k = 0; k < 30; ++k) {
    ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame) << (*source)->message();
    EXPECT_EQ(buffers.frame.sequence, k);
    std::size_t plausible = 0, valid = 0;
    for (std::size_t i = 0; i < buffers.frame.depth.size(); ++i) {
      const std::uint16_t raw = buffers.frame.depth.data[i];
      if (raw == 0 || raw == 65535) continue;
      ++valid;
      plausible += raw > 300 && raw < 10000 ? 1 : 0;
    }
    EXPECT_GT(valid, buffers.frame.depth.size() / 2);
    EXPECT_EQ(plausible, valid) << "frame " << k;
    EXPECT_FALSE(buffers.frame.color.empty());
  }
}

}  // namespace
}  // namespace loopsift
