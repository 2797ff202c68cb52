// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/frame_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift::tool {
namespace {

constexpr std::size_t kRawValues = 65536;
constexpr std::uint16_t kInvalid = 65535;  // besides 0

/// Red at 0, green in the middle, blue at 1.
Rgb8 ramp(double share) {
  const double x = std::clamp(share, 0.0, 1.0);
  const auto level = [](double value) {
    return static_cast<unsigned char>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  };
  return {level(2 - 4 * x), level(x < 0.5 ? 4 * x : 4 - 4 * x), level(4 * x - 2)};
}

}  // namespace

FrameStatistics::FrameStatistics(const SourceInfo& info) : info_(info), depths_(kRawValues) {}

void FrameStatistics::add(const RawFrame& frame, std::int64_t arrived_ns) {
  add_stamps(frame, arrived_ns);
  ++figures_.frames;
  for (int v = 0; v < frame.depth.height; ++v)
    for (int u = 0; u < frame.depth.width; ++u) ++depths_[frame.depth.row(v)[u]];
  pixels_ += static_cast<std::int64_t>(frame.depth.size());
  if (frame.color.empty()) {
    if (info_.color_width > 0) ++figures_.without_color;
    return;
  }
  std::int64_t sum = 0;
  for (int v = 0; v < frame.color.height; ++v) {
    for (int u = 0; u < frame.color.width; ++u) {
      const Rgb8& pixel = frame.color.row(v)[u];
      sum += pixel.r + 2 * pixel.g + pixel.b;
    }
  }
  brightness_sum_ += 0.25 * static_cast<double>(sum) / static_cast<double>(frame.color.size());
  ++colors_;
}

void FrameStatistics::add_stamps(const RawFrame& frame, std::int64_t arrived_ns) {
  if (has_last_) {
    const std::int64_t step_ns = frame.timestamp_ns - last_stamp_ns_;
    const double period_ns = 1e9 / (info_.nominal_rate_hz > 0 ? info_.nominal_rate_hz : 30.0);
    if (step_ns <= 0) ++figures_.stamp_faults;
    if (static_cast<double>(step_ns) > 1.5 * period_ns) ++figures_.stamp_gaps;
    if (frame.sequence > last_sequence_) figures_.missed += frame.sequence - last_sequence_ - 1;
    stamps_ns_ += step_ns;
    arrivals_ns_ += arrived_ns - last_arrived_ns_;
    ++intervals_;
  }
  has_last_ = true;
  last_stamp_ns_ = frame.timestamp_ns;
  last_arrived_ns_ = arrived_ns;
  last_sequence_ = frame.sequence;
}

// The depth that `share` of the valid pixels do not exceed.
double FrameStatistics::depth_at(double share) const {
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(valid_)));
  std::int64_t count = 0;
  for (std::size_t raw = 1; raw < kInvalid; ++raw) {
    count += depths_[raw];
    if (count >= std::max<std::int64_t>(wanted, 1)) return static_cast<double>(raw) * info_.depth_unit_m;
  }
  return 0;
}

FrameFigures FrameStatistics::take() {
  FrameFigures figures = figures_;
  valid_ = pixels_ - depths_[0] - depths_[kInvalid];
  if (pixels_ > 0) figures.valid_share = static_cast<double>(valid_) / static_cast<double>(pixels_);
  figures.near_m = depth_at(0.01);
  figures.median_m = depth_at(0.5);
  figures.far_m = depth_at(0.99);
  if (colors_ > 0) figures.brightness = brightness_sum_ / static_cast<double>(colors_);
  const auto rate = [this](std::int64_t ns) {
    return ns > 0 ? 1e9 * static_cast<double>(intervals_) / static_cast<double>(ns) : 0.0;
  };
  figures.rate_hz = rate(arrivals_ns_);
  figures.stamp_rate_hz = rate(stamps_ns_);
  std::fill(depths_.begin(), depths_.end(), 0);
  figures_ = {};
  pixels_ = stamps_ns_ = arrivals_ns_ = intervals_ = colors_ = 0;
  brightness_sum_ = 0;
  return figures;
}

FramePicture::FramePicture(const RawFrame& frame, double depth_unit_m, const FrameFigures& figures) {
  const ImageView<std::uint16_t>& depth = frame.depth;
  const ImageView<Rgb8>& color = frame.color;
  height_ = depth.empty() ? color.height : depth.height;
  const int color_width = color.empty() ? 0 : color.width * height_ / color.height;
  width_ = depth.width + color_width;
  pixels_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const double range_m = std::max(figures.far_m - figures.near_m, 1e-3);
  const ImageView<Rgb8> out(pixels_.data(), width_, height_);
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const std::uint16_t raw = depth(u, v);
      if (raw != 0 && raw != kInvalid) out(u, v) = ramp((raw * depth_unit_m - figures.near_m) / range_m);
    }
    for (int u = 0; u < color_width; ++u)
      out(depth.width + u, v) = color(u * color.width / color_width, v * color.height / height_);
  }
}

}  // namespace loopsift::tool
