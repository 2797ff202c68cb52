// SPDX-License-Identifier: MIT
// What the frames of a source look like: how much depth, how far, how often, what is missing. In: frames as
// they are read. Out: figures of all of them, or of those since the last take(). One thread; allocates at
// the start only.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "drivers/frame_source.hpp"

namespace loopsift::tool {

struct FrameFigures {
  std::int64_t frames = 0;
  std::int64_t bad = 0;
  std::int64_t without_color = 0;  ///< though the source has colour
  std::int64_t missed = 0;         ///< gaps in the source's own numbers
  std::int64_t stamp_faults = 0;   ///< time stamps that do not go forward
  std::int64_t stamp_gaps = 0;     ///< more than one and a half periods from one time stamp to the next
  double rate_hz = 0;              ///< by arrival; 0 with less than two frames
  double stamp_rate_hz = 0;        ///< by time stamps
  double valid_share = 0;          ///< of the depth pixels
  double near_m = 0, median_m = 0, far_m = 0;  ///< 1 %, 50 % and 99 % of the valid depths
  double brightness = 0;                       ///< mean of the colour images, 0 to 255
};

class FrameStatistics {
 public:
  explicit FrameStatistics(const SourceInfo& info);
  void add(const RawFrame& frame, std::int64_t arrived_ns);
  void add_bad() { ++figures_.bad; }
  /// The figures since the last take(), which begins anew.
  [[nodiscard]] FrameFigures take();

 private:
  void add_stamps(const RawFrame& frame, std::int64_t arrived_ns);
  [[nodiscard]] double depth_at(double share) const;

  SourceInfo info_;
  FrameFigures figures_;
  std::vector<std::int64_t> depths_;  // how often each raw value came
  std::int64_t valid_ = 0, pixels_ = 0;
  double brightness_sum_ = 0;
  std::int64_t colors_ = 0;
  bool has_last_ = false;
  std::int64_t last_stamp_ns_ = 0, last_arrived_ns_ = 0, last_sequence_ = 0;
  std::int64_t stamps_ns_ = 0, arrivals_ns_ = 0, intervals_ = 0;  // between the frames of figures_
};

/// Depth (near red, far blue, none black; from near to far of `figures`) and, to its right and as high, the
/// colour image where there is one.
class FramePicture {
 public:
  FramePicture(const RawFrame& frame, double depth_unit_m, const FrameFigures& figures);
  [[nodiscard]] ImageView<const Rgb8> view() const { return {pixels_.data(), width_, height_}; }

 private:
  int width_ = 0, height_ = 0;
  std::vector<Rgb8> pixels_;
};

}  // namespace loopsift::tool
