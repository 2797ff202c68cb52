// SPDX-License-Identifier: MIT
// What a structured-light depth camera does to a perfect image.
//
//  - lateral jitter of about half a pixel (Nguyen, Izadi & Lovell 2012);
//  - disparity f·b/z with normal noise, rounded to steps of 1/8 pixel, so that depth steps and noise grow
//  with z²
//    (Khoshelham & Elberink 2012);
//  - holes: the projector's shadow beside near objects, depth edges, grazing angles, too near and too far;
//  - a smooth distortion z · (1 + a z P(u, v)) with a fixed polynomial P for each camera, as uncalibrated
//  Kinects
//    show it (Teichman, Miller & Thrun 2013); it does not average out and makes real drift;
//  - normal noise in colour.
#pragma once
#include <cstdint>
#include <vector>

#include "core/geometry/camera.hpp"
#include "core/geometry/image.hpp"
#include "drivers/synth/renderer.hpp"

namespace loopsift {

struct NoiseSettings {
  bool noise = true;                    ///< false: exact depth at any range, clean colour
  bool distortion = true;               ///< independent of `noise`
  std::uint64_t seed = 1;               ///< of the noise and of the camera's distortion
  double depth_unit_m = 0.001;          ///< metres per raw unit of the output
  float baseline_m = 0.075F;            ///< from projector to camera
  float disparity_step_px = 0.125F;     ///< rounding
  float disparity_sigma_steps = 0.25F;  ///< noise before rounding
  float lateral_sigma_px = 0.5F;
  float min_depth_m = 0.4F;
  float max_depth_m = 4.5F;
  float grazing_cosine_none = 0.10F;  ///< nothing comes back below this cosine (84°) …
  float grazing_cosine_all = 0.25F;   ///< … and everything above this one (75°)
  float edge_dropout = 0.5F;          ///< probability of a hole beside a depth edge
  float distortion_per_m = 0.005F;    ///< a: relative error per metre of depth at the pattern's largest
  float color_sigma = 4.0F;           ///< levels of 255
};

/// Construction allocates, apply does not. Thread-safe; a frame's noise depends on the seed and the frame
/// number alone.
class NoiseModel {
 public:
  NoiseModel(const PinholeCamera& camera, const NoiseSettings& settings);

  /// Writes raw depth, width × height of the camera; 0 is invalid.
  void apply_depth(const RenderedFrame& frame, std::uint64_t frame_number,
                   ImageView<std::uint16_t> out) const;
  /// Only when the frame was rendered with colour.
  void apply_color(const RenderedFrame& frame, std::uint64_t frame_number, ImageView<Rgb8> out) const;
  /// P(u, v), in [−1, 1].
  [[nodiscard]] float distortion(int u, int v) const {
    return distortion_[static_cast<std::size_t>(v * camera_.width + u)];
  }

 private:
  [[nodiscard]] float jittered(const RenderedFrame& frame, int u, int v, std::uint64_t bits) const;
  [[nodiscard]] bool keeps(const RenderedFrame& frame, int u, int v, float chance) const;
  [[nodiscard]] float distorted(float depth, int u, int v) const;
  void row_with_noise(const RenderedFrame& frame, std::uint64_t salt, int v, std::uint16_t* out) const;

  PinholeCamera camera_;
  NoiseSettings settings_;
  std::vector<float> distortion_;
};

}  // namespace loopsift
