// SPDX-License-Identifier: MIT
// Colour as the depth camera would see it: each depth pixel takes the colour found where its point projects
// into the colour camera, p_color = T_color_depth · z · K⁻¹ (u, v, 1), through that camera's distortion;
// nearest pixel. Pixels without depth are taken to lie as deep as the last one to their left that has some;
// what the colour camera does not see gets the nearest colour at its image's border, so that no edge arises
// that stands still in the image. A surface that only the depth camera sees gets the colour of what hides it.
// One pass; allocates in the constructor only (a row). Any one thread.
#pragma once
#include <cstdint>
#include <vector>

#include "core/geometry/camera_calibration.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

class ColorRegistrar {
 public:
  /// depth: of the rectified depth image. color: fitted to the colour image (lens.hpp).
  /// color_radius2: largest_radius2(color).
  ColorRegistrar(const PinholeCamera& depth, const LensCalibration& color, double color_radius2,
                 const Se3& T_color_depth, double unit_m);

  /// depth and out have the depth camera's size, color that of the colour lens; color and out do not overlap.
  void register_color(const ImageView<const std::uint16_t>& depth, const ImageView<const Rgb8>& color,
                      const ImageView<Rgb8>& out);

 private:
  /// What the projection of one row needs, in single precision.
  struct RowProjection {
    float x = 0, y = 0, z = 0;     // direction of the row's first pixel, R K⁻¹ (0, v, 1)
    float dx = 0, dy = 0, dz = 0;  // its change from pixel to pixel
    float tx = 0, ty = 0, tz = 0;  // T_color_depth's translation
    float radius2 = 0;             // of normalised coordinates; farther ones are brought to it
    float k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
    float fx = 0, fy = 0, cx = 0, cy = 0;
    float last_column = 0, last_row = 0;
    float mirror_scale = 1, mirror_offset = 0;  // column ← scale · column + offset
    std::int32_t stride = 0;
  };
  static void project_row(const RowProjection& p, const float* depth_m, int count, std::int32_t* source);
  void fill_depths(const std::uint16_t* depth);

  Eigen::Matrix3f H_color_depth_;  // R K⁻¹: a depth pixel's direction in the colour camera
  RowProjection projection_;
  float unit_m_;
  std::vector<float> depth_m_;        // of one row, without holes; 0 (infinitely far) before the first depth
  std::vector<std::int32_t> source_;  // colour pixel of each pixel of one row
};

}  // namespace loopsift
