// SPDX-License-Identifier: MIT
// The capture thread's part of an OpenNI2 camera: what of it takes memory from the heap.
#include <gtest/gtest.h>

#include <atomic>

#include "core/base/heap_watch.hpp"
#include "core/base/steady_time.hpp"
#include "drivers/openni2/openni2_source.hpp"
#include "tests/support/openni2_plugin/test_camera.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kLimitNs = 60'000'000'000;
constexpr int kFrames = 60;

class OpenNi2Heap : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::TestCamera::install()) GTEST_SKIP() << test::TestCamera::kNotAllowed;
  }
  // Reads `frames`; fewer within the time limit are a failure.
  static void read(FrameSource& source, RawFrame& frame, int frames) {
    const std::int64_t limit_ns = steady_now_ns() + kLimitNs;
    for (int k = 0; k < frames && steady_now_ns() < limit_ns;) {
      if (source.read(frame, 100) == ReadStatus::kFrame) ++k;
    }
    ASSERT_LT(steady_now_ns(), limit_ns);
  }
  test::TestCamera camera_;
};

// How many calls OpenNI2 makes depends on how many images came while the reader had no processor.
TEST_F(OpenNi2Heap, WhatReadingTakesIsOpenNi2s) {
  ASSERT_TRUE(heap_is_watched());
  camera_.control.film = camera_.folder() / "film";
  test::write_drawn_film(camera_.control.film, 30, 64, 48, true);
  camera_.control.repeat = true;
  camera_.control.rate_hz = 60;
  camera_.apply();
  SourceOptions options;
  options.camera.width = 64;
  options.camera.height = 48;
  const auto source = open_openni2("", options);
  ASSERT_TRUE(source.ok()) << source.error().message;
  test::FrameBuffers buffers((*source)->info());
  read(**source, buffers.frame, 1);
  std::atomic<std::int64_t> calls{0}, of_openni2{0};
  {
    const HeapSeal seal(&calls, HeapMode::kCount, &of_openni2);
    read(**source, buffers.frame, kFrames);
  }
  EXPECT_EQ(calls, 0);
  EXPECT_GT(of_openni2, 0) << "no pardon is needed any more";
}

}  // namespace
}  // namespace loopsift
