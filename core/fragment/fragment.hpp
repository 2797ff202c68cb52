// SPDX-License-Identifier: MIT
// A fragment: k consecutive frames fused rigidly into surfels (Zhang & Chen, loop sifting, "Model fusion";
// surfels after Pfister et al. 2000, fusion after Keller et al. 2013). Its frame is its first camera; nothing
// in it moves once closed.
#pragma once
#include <cstdint>
#include <vector>

#include "core/base/ids.hpp"
#include "core/base/span.hpp"
#include "core/geometry/camera.hpp"
#include "core/geometry/image.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

/// Surfels in structure-of-arrays form; all spans have the same size. Owns nothing.
struct SurfelSpan {
  Span<float> x, y, z;              ///< position, metres, fragment frame
  Span<float> nx, ny, nz;           ///< unit normal toward the camera that saw it, fragment frame
  Span<float> radius;               ///< metres
  Span<float> weight;               ///< accumulated confidence
  Span<std::uint32_t> rgb;          ///< 0x00RRGGBB
  Span<std::uint16_t> first_frame;  ///< t0: index into Fragment::frames of the frame that created it
  Span<std::uint16_t> last_frame;   ///< t: the same of the one that last updated it
  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// A frame of a fragment, by its pose in it.
struct FragmentFrame {
  FrameId frame;
  std::int64_t timestamp_ns = 0;
  Se3 T_fragment_camera;
  Matrix6d information =
      Matrix6d::Zero();  ///< of the motion from the frame before ((t, ω), right perturbation); zero: unknown
};

/// A frame kept for scoring: its depth reduced by nearest sampling (averaging would mix depths across edges).
struct ScoreView {
  int frame_in_fragment = 0;       ///< index into Fragment::frames
  PinholeCamera camera;            ///< of the reduced image (principal point shifted by the sampling offset)
  ImageView<const float> depth_m;  ///< metres; 0 invalid
  Se3 T_fragment_camera;
};

/// A closed fragment. Spans and views point into the FragmentStore that owns it.
struct Fragment {
  FragmentId id;
  Se3 T_odom_fragment;             ///< pose of its first camera in the odometry's world
  bool joined_to_previous = true;  ///< false: tracking was lost before it, it hangs on no odometry edge
  Span<const FragmentFrame> frames;
  SurfelSpan surfels;
  Span<const ScoreView> views;
  float disparity_unknown = 1.0F;  ///< mean of Frame::disparity_unknown over the frames
};

}  // namespace loopsift
