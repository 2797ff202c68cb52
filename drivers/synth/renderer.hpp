// SPDX-License-Identifier: MIT
// Ray casting with Embree: what a perfect RGB-D camera sees.
#pragma once
#include <memory>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/camera.hpp"
#include "core/geometry/se3.hpp"
#include "drivers/synth/scene.hpp"

namespace loopsift {

/// One image without noise, row by row, width × height of the camera.
struct RenderedFrame {
  int width = 0, height = 0;
  std::vector<float> depth;   ///< z in metres; 0 where the ray leaves the scene
  std::vector<float> cosine;  ///< of the angle between ray and surface normal, in [0, 1]
  std::vector<Rgb8> color;    ///< empty when not asked for
};

/// Holds the scene's acceleration structure. Construction allocates; render() allocates only when `out`
/// grows. render() may run in several threads at once, each with its own `out`. Results are the same on every
/// run on one machine; another instruction set may differ in the last bits.
class Renderer {
 public:
  /// Copies what it needs of the scene. Errors: kUnsupported when Embree does not start.
  [[nodiscard]] static Expected<std::unique_ptr<Renderer>> create(const Scene& scene);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  void render(const PinholeCamera& camera, const Se3& T_world_camera, bool want_color,
              RenderedFrame* out) const;

 private:
  struct Embree;
  struct Packet;
  /// What shading needs of a triangle.
  struct Face {
    float light_front, light_back;  ///< brightness seen from either side
    int axis;                       ///< that it faces most
  };
  Renderer(const Scene& scene, std::unique_ptr<Embree> embree);
  void store(const Packet& packet, int x, int y, bool want_color, RenderedFrame* out) const;
  [[nodiscard]] Rgb8 shade(const Packet& packet, int lane) const;

  Scene scene_;
  std::vector<Face> faces_;
  std::unique_ptr<Embree> embree_;
};

}  // namespace loopsift
