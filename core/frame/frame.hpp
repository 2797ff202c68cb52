// SPDX-License-Identifier: MIT
// From a raw depth image to what tracking and fusion work on: metric depth, reduced, smoothed, as a pyramid
// with normals. In: RawFrame. Out: Frame, valid until the next process(). Capacity: kMaxLevels levels of the
// working size, from the arena. Thread: front. No allocation after construction.
#pragma once
#include <array>
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/ids.hpp"
#include "core/base/result.hpp"
#include "core/frame/disparity_correction.hpp"
#include "core/geometry/camera.hpp"
#include "core/geometry/image.hpp"
#include "core/geometry/raw_frame.hpp"

namespace loopsift {

inline constexpr int kMaxFrameLevels = 4;

struct FrameOptions {
  int reduction = 4;            ///< input pixels per working pixel in each direction: 1, 2 or 4
  int levels = 2;               ///< pyramid levels, 1 … kMaxFrameLevels
  float min_depth_m = 0.3F;     ///< nearer is invalid
  float max_depth_m = 4.5F;     ///< farther is invalid
  float edge_fraction = 0.03F;  ///< neighbours whose depths differ by more than this part of the depth lie on
                                ///< two surfaces: never averaged, no normal across them
  int smoothing_radius = 1;     ///< working pixels of the edge-aware mean below the normals; 0: none
};

/// An error that names the first option out of range.
[[nodiscard]] Status validate(const FrameOptions& options);

/// One pyramid level. All images have the camera's size, without padding.
struct FrameLevel {
  PinholeCamera camera;
  ImageView<const float> depth_m;     ///< metres; 0 invalid
  ImageView<const float> nx, ny, nz;  ///< unit normal toward the camera, camera frame; 0, 0, 0 where unknown
  ImageView<const float> intensity;   ///< logarithmic, see intensity.hpp; empty() without colour
};

/// A preprocessed frame. Views point into the FramePreprocessor and into the RawFrame that it came from.
struct Frame {
  FrameId id;
  std::int64_t timestamp_ns = 0;
  int level_count = 0;
  std::array<FrameLevel, kMaxFrameLevels> levels;  ///< 0 is the finest
  float valid_fraction = 0;                        ///< of level 0's pixels that have a depth
  ImageView<const std::uint16_t> raw_depth;        ///< as it came
  PinholeCamera raw_camera;
  float depth_unit_m = 0.001F;                 ///< metres per raw unit
  float min_depth_m = 0, max_depth_m = 65.0F;  ///< raw depths outside do not count, as in levels
  ImageView<const Rgb8> color;                 ///< empty() without colour
  DisparityCoefficients disparity_coefficients =
      DisparityCoefficients::Zero();  ///< of the correction that is in levels' depths, and not in raw_depth
  ImageView<const float> disparity;   ///< the same per pixel of level 0, 1/m
  float disparity_unknown = 1.0F;     ///< what was not yet known of the error: variance, share of the prior's
};

class FramePreprocessor {
 public:
  /// camera is that of the raw depth images; options must be valid.
  FramePreprocessor(const PinholeCamera& camera, double depth_unit_m, const FrameOptions& options,
                    Arena& arena);
  /// raw.depth must have the camera's size. Frames are numbered from 0 in the order of these calls.
  const Frame& process(const RawFrame& raw);
  /// From the next frame on, depths are corrected by these (0: as they come). unknown: what is left to learn
  /// of them, 0 … 1 (Frame::disparity_unknown).
  void set_disparity(const DisparityCoefficients& coefficients, float unknown);
  /// Camera of level 0.
  [[nodiscard]] const PinholeCamera& working_camera() const { return frame_.levels[0].camera; }
  /// Camera of the last level.
  [[nodiscard]] const PinholeCamera& coarsest_camera() const {
    return frame_.levels[static_cast<std::size_t>(options_.levels) - 1].camera;
  }

 private:
  struct Level {
    Span<float> depth, nx, ny, nz, intensity;
  };
  void reduce();
  void correct();
  void add_intensity();
  void add_normals(std::size_t level);
  [[nodiscard]] ImageView<float> depth_image(std::size_t level) const;

  FrameOptions options_;
  Frame frame_;
  std::array<Level, kMaxFrameLevels> storage_;
  Span<float> disparity_;  // correction per pixel of level 0
  DisparityCoefficients next_disparity_ = DisparityCoefficients::Zero();
  float next_unknown_ = 1.0F;
  Span<float> smoothed_;          // scratch of level 0's size
  Span<float> reduced_;           // scratch: half the raw size, for a reduction by 4
  PinholeCamera reduced_camera_;  // of reduced_
  int next_id_ = 0;
};

}  // namespace loopsift
