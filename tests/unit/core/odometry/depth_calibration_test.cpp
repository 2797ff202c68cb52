// SPDX-License-Identifier: MIT
#include "core/odometry/depth_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/support/analytic_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::SceneCamera;
using test::shifted;
using test::small_camera;

// A camera whose inverse depth is wrong by D, turning to and fro in a room.
class Turning {
 public:
  explicit Turning(const DisparityCoefficients& error) : error_(error), camera_(small_camera(), 3) {
    Arena measuring;
    carve(measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    carve(*arena_);
  }
  const Frame& frame_at(const Se3& T) {
    RawFrame raw = camera_.capture(AnalyticScene::room(), T, 0.001, 0.001);
    std::vector<float> disparity(camera_.pixels().size());
    draw_disparity(error_, {disparity.data(), raw.depth.width, raw.depth.height});
    for (std::size_t k = 0; k < disparity.size(); ++k) {
      const double z = camera_.pixels()[k] * SceneCamera::kUnitM;
      camera_.pixels()[k] = static_cast<std::uint16_t>(
          std::lround(z / (1 - z * static_cast<double>(disparity[k])) / SceneCamera::kUnitM));
    }
    return preprocessor_->process(raw);
  }
  // Keyframe pairs 0.3 rad apart, their poses known to a few millimetres.
  DisparityCoefficients calibrate(int pairs) {
    DepthCalibration calibration((DepthCalibrationOptions()));
    for (int i = 0; i < pairs; ++i) {
      const auto pose = [](int k) {
        return shifted(0.1 * std::sin(k), 0, 0.1 * std::cos(k)) *
               Se3(so3_exp(0.3 * Eigen::Vector3d(std::cos(1.7 * k), std::sin(k), std::cos(2.3 * k))),
                   Eigen::Vector3d::Zero());
      };
      keyframe_->keep(frame_at(pose(i)), pose(i));
      const Frame& frame = frame_at(pose(i + 1));
      Vector6d off;
      off << 0.004, -0.003, 0.002, 0.002, 0.001, -0.002;
      EXPECT_TRUE(calibration.add_pair(*keyframe_, frame, pose(i + 1) * Se3::exp(off)));
      preprocessor_->set_disparity(calibration.coefficients(), calibration.unknown());
    }
    unknown_ = calibration.unknown();
    return calibration.coefficients();
  }
  [[nodiscard]] float unknown() const { return unknown_; }
  Keyframe& keyframe() { return *keyframe_; }

 private:
  void carve(Arena& arena) {
    FrameOptions options;
    options.reduction = 2;
    preprocessor_ = std::make_unique<FramePreprocessor>(small_camera(), SceneCamera::kUnitM, options, arena);
    keyframe_ = std::make_unique<Keyframe>(preprocessor_->working_camera(), options.levels, arena);
  }
  DisparityCoefficients error_;
  float unknown_ = 1.0F;
  SceneCamera camera_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<FramePreprocessor> preprocessor_;
  std::unique_ptr<Keyframe> keyframe_;
};

// Root of the mean squared D over the image.
double size_of(const DisparityCoefficients& c) {
  std::vector<float> image(64 * 48);
  draw_disparity(c, {image.data(), 64, 48});
  double sum = 0;
  for (const float d : image) sum += static_cast<double>(d) * static_cast<double>(d);
  return std::sqrt(sum / static_cast<double>(image.size()));
}

TEST(DepthCalibration, FindsASmoothError) {
  DisparityCoefficients error;
  error << -0.002, 0.001, 0.002, 0.001, -0.002, 0.002, 0.001, -0.001, -0.001;
  Turning camera(error);
  const DisparityCoefficients found = camera.calibrate(30);
  EXPECT_LT(size_of(found - error), 0.15 * size_of(error)) << found.transpose();
}

TEST(DepthCalibration, SaysWhatIsLeftToLearn) {
  Turning camera(DisparityCoefficients::Zero());
  EXPECT_EQ(DepthCalibration((DepthCalibrationOptions())).unknown(), 1.0F);
  (void)camera.calibrate(1);
  const float early = camera.unknown();
  EXPECT_LT(early, 1.0F);
  (void)camera.calibrate(30);
  EXPECT_LT(camera.unknown(), 0.3F * early);
  EXPECT_GT(camera.unknown(), 0.0F);
}

TEST(DepthCalibration, LeavesATrueCameraAlone) {
  Turning camera(DisparityCoefficients::Zero());
  EXPECT_LT(size_of(camera.calibrate(12)), 0.0004) << "0.4 mm at 1 m";
}

TEST(DepthCalibration, FramesOfDifferentPlacesSayNothing) {
  Turning camera(DisparityCoefficients::Zero());
  camera.keyframe().keep(camera.frame_at(Se3()), Se3());
  DepthCalibration calibration((DepthCalibrationOptions()));
  EXPECT_FALSE(calibration.add_pair(camera.keyframe(), camera.frame_at(Se3()), shifted(0, 0, 0, M_PI)));
  EXPECT_EQ(calibration.coefficients().norm(), 0.0);
}

TEST(DepthCalibrationOptions, ErrorsNameTheOption) {
  EXPECT_TRUE(validate(DepthCalibrationOptions()).ok());
  DepthCalibrationOptions options;
  options.memory = 1.5F;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("depth_calibration.memory"));
}

}  // namespace
}  // namespace loopsift
