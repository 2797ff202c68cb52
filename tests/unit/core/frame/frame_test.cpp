// SPDX-License-Identifier: MIT
#include "core/frame/frame.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "tests/support/analytic_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::SceneCamera;
using test::small_camera;

class Preprocessing {
 public:
  explicit Preprocessing(const FrameOptions& options) : arena_(bytes(options)) {
    preprocessor_ = std::make_unique<FramePreprocessor>(small_camera(), SceneCamera::kUnitM, options, arena_);
  }
  const Frame& operator()(const RawFrame& raw) { return preprocessor_->process(raw); }

 private:
  static std::size_t bytes(const FrameOptions& options) {
    Arena measuring;
    const FramePreprocessor unused(small_camera(), SceneCamera::kUnitM, options, measuring);
    return measuring.used_bytes();
  }
  Arena arena_;
  std::unique_ptr<FramePreprocessor> preprocessor_;
};

FrameOptions reduced_by(int reduction) {
  FrameOptions options;
  options.reduction = reduction;
  return options;
}

TEST(Frame, NormalsOfATiltedPlane) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  const AnalyticScene scene{{{n, -1.5}}, {}};
  SceneCamera camera(small_camera(), 1);
  for (const int reduction : {1, 2, 4}) {
    Preprocessing preprocess(reduced_by(reduction));
    const Frame& frame = preprocess(camera.capture(scene, Se3()));
    for (int l = 0; l < frame.level_count; ++l) {
      const FrameLevel& level = frame.levels[static_cast<std::size_t>(l)];
      for (int y = 6; y < level.camera.height - 6; y += 5) {
        for (int x = 6; x < level.camera.width - 6; x += 5) {
          const Eigen::Vector3d measured(level.nx(x, y), level.ny(x, y), level.nz(x, y));
          ASSERT_GT(measured.dot(n), std::cos(1.0 * M_PI / 180))
              << "reduction " << reduction << " level " << l;
        }
      }
    }
  }
}

TEST(Frame, ReducedPixelsLieOnThePlaneThatTheirCameraSays) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.4, 0.2, -1).normalized();
  const AnalyticScene scene{{{n, -1.5}}, {}};
  SceneCamera camera(small_camera(), 1);
  for (const int reduction : {1, 2, 4}) {
    Preprocessing preprocess(reduced_by(reduction));
    const Frame& frame = preprocess(camera.capture(scene, Se3()));
    const FrameLevel& level = frame.levels[0];
    EXPECT_EQ(level.camera.width, small_camera().width / reduction);
    for (int y = 3; y < level.camera.height - 3; y += 7)
      for (int x = 3; x < level.camera.width - 3; x += 7) {
        const Eigen::Vector3f p =
            level.camera.unproject(static_cast<float>(x), static_cast<float>(y), level.depth_m(x, y));
        ASSERT_LT(scene.distance(p.cast<double>()), 0.001);
      }
  }
}

TEST(Frame, ReductionNeverMixesTwoSurfaces) {
  // A step from 1 m to 2 m at an odd column: the blocks on it see both.
  SceneCamera camera(small_camera(), 1);
  RawFrame raw = camera.black();
  for (std::size_t i = 0; i < camera.pixels().size(); ++i)
    camera.pixels()[i] = i % 320 < 161 ? std::uint16_t{10000} : std::uint16_t{20000};
  for (const int reduction : {2, 4}) {
    Preprocessing preprocess(reduced_by(reduction));
    const Frame& frame = preprocess(raw);
    for (int l = 0; l < frame.level_count; ++l) {
      const ImageView<const float>& depth = frame.levels[static_cast<std::size_t>(l)].depth_m;
      for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
          ASSERT_THAT(depth(x, y),
                      testing::AnyOf(testing::FloatNear(1.0F, 1e-4F), testing::FloatNear(2.0F, 1e-4F)));
    }
  }
}

TEST(Frame, InvalidValuesGiveNoDepthAndNothingIsEverNaN) {
  SceneCamera camera(small_camera(), 1);
  RawFrame raw = camera.black();
  std::mt19937 random(3);
  const std::uint16_t values[] = {0, 65535, 100, 60000, 15000, 15010, 25000, 1};
  for (std::uint16_t& pixel : camera.pixels()) pixel = values[random() % 8];
  FrameOptions options = reduced_by(2);
  options.levels = 4;
  Preprocessing preprocess(options);
  const Frame& frame = preprocess(raw);
  for (int l = 0; l < frame.level_count; ++l) {
    const FrameLevel& level = frame.levels[static_cast<std::size_t>(l)];
    for (int y = 0; y < level.camera.height; ++y)
      for (int x = 0; x < level.camera.width; ++x) {
        const float z = level.depth_m(x, y);
        ASSERT_TRUE(z == 0.0F || (z >= options.min_depth_m && z <= options.max_depth_m)) << z;
        const float length = std::hypot(level.nx(x, y), level.ny(x, y), level.nz(x, y));
        ASSERT_TRUE(length == 0.0F || std::fabs(length - 1.0F) < 1e-3F) << length;
      }
  }
}

TEST(Frame, AllInvalidAndSaturatedFramesAreEmpty) {
  SceneCamera camera(small_camera(), 1);
  Preprocessing preprocess(reduced_by(4));
  EXPECT_EQ(preprocess(camera.black()).valid_fraction, 0.0F);
  RawFrame raw = camera.black();
  std::fill(camera.pixels().begin(), camera.pixels().end(), std::uint16_t{65535});
  EXPECT_EQ(preprocess(raw).valid_fraction, 0.0F);
}

TEST(Frame, NumbersFramesInOrder) {
  SceneCamera camera(small_camera(), 1);
  Preprocessing preprocess(reduced_by(4));
  EXPECT_EQ(preprocess(camera.black()).id, FrameId{0});
  EXPECT_EQ(preprocess(camera.black()).id, FrameId{1});
}

TEST(FrameOptions, ErrorsNameTheOption) {
  EXPECT_TRUE(validate(FrameOptions()).ok());
  FrameOptions options;
  options.reduction = 3;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("frame.reduction"));
  options = {};
  options.max_depth_m = 0.1F;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("frame.max_depth_m"));
  options = {};
  options.edge_fraction = std::nanf("");
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("frame.edge_fraction"));
}

}  // namespace
}  // namespace loopsift
