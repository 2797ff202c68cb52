// SPDX-License-Identifier: MIT
// What stands between a driver and the frame queue takes nothing from the heap once it runs.
#include <gtest/gtest.h>

#include "core/base/heap_watch.hpp"
#include "drivers/calibration/calibrated_source.hpp"
#include "drivers/paired_source.hpp"
#include "tests/support/listed_source.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift {
namespace {

using test::ListedFrame;
using test::ListedSource;

TEST(CalibrationHeap, PairedAndCalibratedFramesMakeNoCall) {
  ASSERT_TRUE(heap_is_watched());
  SourceInfo depth, color;
  depth.camera = {32, 24, 30.0F, 30.0F, 15.5F, 11.5F};
  color.color_width = 32;
  color.color_height = 24;
  constexpr std::int64_t kPeriodNs = 33'333'333;
  std::vector<ListedFrame> depths(12), colors(9);  // with colour too early, kept ahead, and missing
  for (std::size_t i = 0; i < depths.size(); ++i)
    depths[i].timestamp_ns = static_cast<std::int64_t>(i) * kPeriodNs;
  for (std::size_t i = 0; i < colors.size(); ++i)
    colors[i].timestamp_ns = static_cast<std::int64_t>(i < 5 ? i : i + 2) * kPeriodNs - 1;
  CameraCalibration calibration;
  calibration.file = "camera.toml";
  calibration.depth.distortion.k1 = -0.1;
  calibration.color.camera = {32, 24, 28.0F, 28.0F, 15.5F, 11.5F};
  calibration.T_color_depth = Se3(Eigen::Matrix3d::Identity(), {-0.025, 0, 0});
  auto paired = PairedSource::create(std::make_unique<ListedSource>(depth, depths),
                                     std::make_unique<ListedSource>(color, colors));
  ASSERT_TRUE(paired.ok());
  const auto source = CalibratedSource::create(std::move(*paired), calibration, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  test::FrameBuffers buffers((*source)->info());
  ASSERT_EQ((*source)->read(buffers.frame, 0), ReadStatus::kFrame);
  std::atomic<std::int64_t> calls{0};
  int frames = 0, colored = 0;
  {
    const HeapSeal seal(&calls, HeapMode::kCount);
    while ((*source)->read(buffers.frame, 0) == ReadStatus::kFrame) {
      ++frames;
      if (!buffers.frame.color.empty()) ++colored;
    }
  }
  EXPECT_EQ(frames, 11);
  EXPECT_EQ(colored, 8);
  EXPECT_EQ(calls, 0);
}

}  // namespace
}  // namespace loopsift
