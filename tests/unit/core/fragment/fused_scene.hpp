// SPDX-License-Identifier: MIT
// Analytic scenes through preprocessing into a builder and a store, all in an arena of the measured size.
#pragma once
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/fragment/fragment_builder.hpp"
#include "tests/support/analytic_scene.hpp"

namespace loopsift::test {

inline StoreOptions small_store() {
  StoreOptions options;
  options.max_fragments = 8;
  options.max_surfels = 200000;
  options.max_frames = 400;
  options.max_views = 24;
  return options;
}

inline FrameOptions halved() {
  FrameOptions options;
  options.reduction = 2;
  return options;
}

class FusedScene {
 public:
  explicit FusedScene(AnalyticScene s, const FragmentOptions& fragment = {},
                      const StoreOptions& stored = small_store())
      : scene(std::move(s)), camera(small_camera(), 5) {
    Arena measuring;
    const Parts unused(fragment, stored, measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    parts_ = std::make_unique<Parts>(fragment, stored, *arena_);
  }
  void add(const Se3& T, double noise_floor_m = 0, double noise_slope = 0) {
    add_with(T, Matrix6d::Identity(), noise_floor_m, noise_slope);
  }
  void add_with(const Se3& T, const Matrix6d& information, double noise_floor_m = 0, double noise_slope = 0) {
    builder().integrate(preprocess(camera.capture(scene, T, noise_floor_m, noise_slope)), T, information,
                        true);
  }
  const Frame& preprocess(const RawFrame& raw) { return parts_->preprocessor.process(raw); }
  FragmentBuilder& builder() { return parts_->builder; }
  FragmentStore& store() { return parts_->store; }
  // RMS distance of surfels to the scene, metres.
  [[nodiscard]] double surface_error(const SurfelSpan& s, const Se3& T_world_surfels) const {
    double sum = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      const double d =
          scene.distance(T_world_surfels * Eigen::Vector3f(s.x[i], s.y[i], s.z[i]).cast<double>());
      sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(s.size()));
  }
  // The median distance: single pixels on silhouettes do not count.
  [[nodiscard]] double median_error(const SurfelSpan& s, const Se3& T_world_surfels) const {
    std::vector<double> distances;
    for (std::size_t i = 0; i < s.size(); ++i)
      distances.push_back(
          scene.distance(T_world_surfels * Eigen::Vector3f(s.x[i], s.y[i], s.z[i]).cast<double>()));
    std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                     distances.end());
    return distances[distances.size() / 2];
  }

  AnalyticScene scene;
  SceneCamera camera;

 private:
  struct Parts {
    Parts(const FragmentOptions& fragment, const StoreOptions& stored, Arena& arena)
        : preprocessor(small_camera(), SceneCamera::kUnitM, halved(), arena),
          builder(fragment, preprocessor.working_camera(), small_camera(), arena),
          store(stored, arena) {}
    FramePreprocessor preprocessor;
    FragmentBuilder builder;
    FragmentStore store;
  };
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace loopsift::test
