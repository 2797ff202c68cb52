// SPDX-License-Identifier: MIT
// A source that plays what a test lists: what each read returns, with which time stamp and pixels.
#pragma once
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "drivers/frame_source.hpp"

namespace loopsift::test {

struct ListedFrame {
  std::int64_t timestamp_ns = 0;
  std::vector<std::uint16_t> depth;  ///< as large as the camera, or empty: all pixels are `depth_value`
  std::uint16_t depth_value = 0;
  std::vector<Rgb8> color;  ///< as large as the colour image, or empty: all pixels are `color_value`
  unsigned char color_value = 0;
  bool has_color = true;
  ReadStatus status = ReadStatus::kFrame;
  std::string message;
};

class ListedSource final : public FrameSource {
 public:
  ListedSource(SourceInfo info, std::vector<ListedFrame> frames)
      : info_(std::move(info)), frames_(std::move(frames)) {
    timeouts.reserve(frames_.size() + 1);
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] const std::string& message() const override { return message_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override {
    timeouts.push_back(timeout_ms);
    message_.clear();
    if (next_ == frames_.size()) return ReadStatus::kEnd;
    const ListedFrame& listed = frames_[next_++];
    message_ = listed.message;
    if (listed.status != ReadStatus::kFrame) return listed.status;
    frame.timestamp_ns = listed.timestamp_ns;
    frame.sequence = static_cast<std::int64_t>(next_) - 1;
    frame.depth = {frame.depth_buffer.data(), info_.camera.width, info_.camera.height};
    fill(listed.depth, listed.depth_value, frame.depth);
    frame.color = {};
    if (info_.color_width == 0 || !listed.has_color) return ReadStatus::kFrame;
    frame.color = {frame.color_buffer.data(), info_.color_width, info_.color_height};
    fill(listed.color, {listed.color_value, listed.color_value, listed.color_value}, frame.color);
    return ReadStatus::kFrame;
  }

  std::vector<int> timeouts;  ///< that read() was called with

 private:
  template <class T>
  static void fill(const std::vector<T>& pixels, T value, const ImageView<T>& image) {
    if (pixels.empty()) {
      std::fill_n(image.data, image.size(), value);
    } else {
      std::copy_n(pixels.begin(), image.size(), image.data);
    }
  }

  SourceInfo info_;
  std::vector<ListedFrame> frames_;
  std::size_t next_ = 0;
  std::string message_;
};

}  // namespace loopsift::test
