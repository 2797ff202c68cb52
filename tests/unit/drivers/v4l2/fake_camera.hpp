// SPDX-License-Identifier: MIT
// A source on a fake device, with the buffers that a consumer would give it.
#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "drivers/v4l2/v4l2_source.hpp"
#include "tests/support/fake_video.hpp"

namespace loopsift::test {

inline constexpr int kWidth = 8, kHeight = 4;
inline constexpr std::int64_t kMs = 1'000'000;

class FakeCamera : public ::testing::Test {
 protected:
  FakeCamera() {
    options_.camera = {kWidth, kHeight, 10, 10, 4, 2};
    options_.v4l2.width = kWidth;
    options_.v4l2.height = kHeight;
  }

  void open(const std::string& device = "/dev/video0") {
    auto opened = open_v4l2(video_, device, options_);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    source_ = std::move(*opened);
    frame_.depth_buffer = {depth_.data(), depth_.size()};
    frame_.color_buffer = {color_.data(), color_.size()};
  }
  /// Why the device does not open; nothing must stay open or mapped.
  Error open_error(const std::string& device = "/dev/video0") {
    auto opened = open_v4l2(video_, device, options_);
    if (opened.ok()) return {ErrorCode::kNumeric, "it opened"};
    EXPECT_TRUE(video_.all_given_back());
    return opened.error();
  }
  ReadStatus read() { return source_->read(frame_, 100); }

  /// A frame of that many bytes, 10 ms old when it is read; the next one is read 33 ms later.
  static VideoEvent frame(std::vector<std::uint8_t> bytes, std::uint32_t sequence,
                          std::int64_t timestamp_ns) {
    VideoEvent event;
    event.bytes = std::move(bytes);
    event.sequence = sequence;
    event.timestamp_ns = timestamp_ns;
    return event;
  }
  static VideoEvent depth_frame(std::uint32_t sequence, std::int64_t timestamp_ns) {
    return frame(std::vector<std::uint8_t>(2 * kWidth * kHeight, 1), sequence, timestamp_ns);
  }
  static VideoEvent take_error(int error_number) {
    VideoEvent event;
    event.kind = VideoEvent::Kind::kTakeError;
    event.error_number = error_number;
    return event;
  }

  FakeVideo video_;
  SourceOptions options_;
  std::unique_ptr<FrameSource> source_;
  RawFrame frame_;
  std::vector<std::uint16_t> depth_ = std::vector<std::uint16_t>(kWidth * kHeight);
  std::vector<Rgb8> color_ = std::vector<Rgb8>(kWidth * kHeight);
};

}  // namespace loopsift::test
