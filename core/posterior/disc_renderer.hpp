// SPDX-License-Identifier: MIT
// Z-buffered surfel discs, as inverse depth: over a plane 1/z is affine in the pixel, so a disc costs no
// division per pixel, and the nearest surface is the largest value. Never allocates.
#pragma once
#include "core/geometry/camera.hpp"
#include "core/geometry/image.hpp"
#include "core/geometry/se3.hpp"
#include "core/posterior/score_surfels.hpp"

namespace loopsift {

/// Discs seen flatter than this (cosine of the angle between ray and normal) are skipped: their silhouettes
/// are noise.
constexpr float kGrazingCosine = 0.17F;

/// Elements from row to row of an image that render_discs may write to: it works on eight pixels at a time
/// and uses the padding behind a row.
[[nodiscard]] constexpr int padded_stride(int width) { return width + 8; }

/// An image over `data`, of the camera's size and with such a stride.
[[nodiscard]] inline ImageView<float> padded_image(float* data, const PinholeCamera& camera) {
  return {data, camera.width, camera.height, padded_stride(camera.width)};
}

/// What a camera sees between two depths, camera frame, metres.
class Frustum {
 public:
  Frustum(const PinholeCamera& camera, float min_depth_m, float max_depth_m);
  /// False where the sphere lies wholly outside one of its faces.
  [[nodiscard]] bool meets(const Eigen::Vector3f& center, float radius) const;

 private:
  Eigen::Matrix<float, 4, 3> sides_;  // unit normals, outward
  float min_depth_m_, max_depth_m_;
};

/// Splats the discs, at camera pose given by T_camera_fragment, into inverse_depth (1/m; 0 where nothing is
/// predicted; must have the
/// camera's size and a padded_stride, and be cleared by the caller). Discs nearer than min_depth_m or
/// past max_depth_m, those that show their back and grazing ones are skipped; the pixel at a disc's centre is
/// always written.
void render_discs(const ScoreSurfels& surfels, const Se3& T_camera_fragment, const PinholeCamera& camera,
                  float min_depth_m, float max_depth_m, const ImageView<float>& inverse_depth);

/// The same in its plain form, disc by disc with exact ray–plane intersections: the reference in tests.
void render_discs_plain(const ScoreSurfels& surfels, const Se3& T_camera_fragment,
                        const PinholeCamera& camera, float min_depth_m, float max_depth_m,
                        const ImageView<float>& inverse_depth);

}  // namespace loopsift
