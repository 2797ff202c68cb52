// SPDX-License-Identifier: MIT
// An analytic scene seen through the frame preprocessor, and an exact model of it to track against.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "core/odometry/odometry.hpp"
#include "tests/support/analytic_scene.hpp"

namespace loopsift::test {

class TrackedScene {
 public:
  explicit TrackedScene(AnalyticScene scene, int reduction, double noise_floor_m = 0, double noise_slope = 0)
      : scene_(std::move(scene)), camera_(small_camera(), 11), floor_m_(noise_floor_m), slope_(noise_slope) {
    options_.reduction = reduction;
    Arena measuring;
    const FramePreprocessor unused(small_camera(), SceneCamera::kUnitM, options_, measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    preprocessor_ =
        std::make_unique<FramePreprocessor>(small_camera(), SceneCamera::kUnitM, options_, *arena_);
  }
  const Frame& frame_at(const Se3& T_world_camera) {
    return preprocessor_->process(camera_.capture(scene_, T_world_camera, floor_m_, slope_));
  }
  const Frame& color_frame_at(const Se3& T_world_camera, double gain = 1) {
    return preprocessor_->process(camera_.capture_color(scene_, T_world_camera, floor_m_, slope_, gain));
  }
  const PinholeCamera& working_camera() const { return preprocessor_->working_camera(); }
  const Frame& black_frame() { return preprocessor_->process(camera_.black()); }
  // The scene without noise, at the frame's resolution; valid until the next call.
  ModelView model_at(const Se3& T_world_view) {
    const Frame& frame = preprocessor_->process(camera_.capture(scene_, T_world_view));
    const FrameLevel& level = frame.levels[0];
    const int w = level.camera.width, h = level.camera.height;
    for (auto& image : model_) image.assign(static_cast<std::size_t>(w * h), 0.0F);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const auto k = static_cast<std::size_t>(y * w + x);
        const Eigen::Vector3f n(level.nx(x, y), level.ny(x, y), level.nz(x, y));
        if (n.norm() < 0.5F) continue;
        const Eigen::Vector3f p =
            level.camera.unproject(static_cast<float>(x), static_cast<float>(y), level.depth_m(x, y));
        for (std::size_t i = 0; i < 3; ++i) {
          model_[i][k] = p[static_cast<int>(i)];
          model_[i + 3][k] = n[static_cast<int>(i)];
        }
      }
    }
    const auto view = [&](std::size_t i) { return ImageView<const float>(model_[i].data(), w, h); };
    return {level.camera, T_world_view, view(0), view(1), view(2), view(3), view(4), view(5)};
  }

 private:
  AnalyticScene scene_;
  SceneCamera camera_;
  double floor_m_, slope_;
  FrameOptions options_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<FramePreprocessor> preprocessor_;
  std::array<std::vector<float>, 6> model_;
};

}  // namespace loopsift::test
