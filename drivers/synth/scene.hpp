// SPDX-License-Identifier: MIT
// What is rendered: triangles with materials, and the builder that puts primitives together. World frame: z
// up, metres. Set-up code: allocates.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/synth/mesh.hpp"
#include "drivers/synth/texture.hpp"

namespace loopsift {

struct Scene {
  TriangleMesh mesh;
  std::vector<Eigen::Vector2f>
      uv;  ///< surface coordinates in metres, per vertex; empty: projected from position
  std::vector<std::uint16_t> material_of;  ///< per triangle
  std::vector<Material> materials;         ///< at least one

  /// Every surface in the same plain grey: nothing but geometry for a tracker.
  void remove_texture();
};

/// A scene around somebody else's mesh: its vertex colours, or a mottled surface where it has none.
[[nodiscard]] Scene make_scene(TriangleMesh mesh);

/// Where an object stands: turned by yaw (counter-clockwise from above), then moved.
struct Placement {
  float x = 0, y = 0, z = 0;  ///< metres
  float yaw_deg = 0;
};

/// Collects primitives, given in the coordinates of the current placement (x right, y to the front, z up).
class SceneBuilder {
 public:
  /// The frame of the primitives that follow.
  void place(const Placement& placement);
  [[nodiscard]] const Placement& placement() const { return placement_; }

  /// Axis-aligned in local coordinates.
  void box(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const Material& material);
  /// Upright, from radius `bottom` at base to radius `top` at base + height; closed on both ends.
  void frustum(const Eigen::Vector3f& base, float bottom, float top, float height, const Material& material);
  void cylinder(const Eigen::Vector3f& base, float radius, float height, const Material& material) {
    frustum(base, radius, radius, height, material);
  }
  /// An ellipsoid with the given half axes.
  void ellipsoid(const Eigen::Vector3f& center, const Eigen::Vector3f& radii, const Material& material);

  [[nodiscard]] Scene finish() { return std::move(scene_); }

 private:
  int vertex(const Eigen::Vector3f& local, float u, float v);
  void triangle(int a, int b, int c);
  void quad(const Eigen::Vector3f& corner, const Eigen::Vector3f& along_u, const Eigen::Vector3f& along_v);
  void start(const Material& material);

  Scene scene_;
  Placement placement_;
  float cos_yaw_ = 1, sin_yaw_ = 0;
};

}  // namespace loopsift
