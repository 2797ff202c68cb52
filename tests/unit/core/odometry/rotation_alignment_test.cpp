// SPDX-License-Identifier: MIT
#include "core/odometry/rotation_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/unit/core/odometry/tracked_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::TrackedScene;

Se3 turned(double x, double y, double z) {
  return {so3_exp(Eigen::Vector3d(x, y, z)), Eigen::Vector3d::Zero()};
}

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return so3_log(a.transpose() * b).norm();
}

class Turn : public testing::Test {
 protected:
  explicit Turn(AnalyticScene scene = AnalyticScene::room()) : scene_(std::move(scene), 2, 0.0012, 0.0019) {
    const PinholeCamera coarsest = scene_.working_camera().block_averaged(2);
    Arena measuring;
    const RotationAlignment unused(coarsest, measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    alignment_ = std::make_unique<RotationAlignment>(coarsest, *arena_);
  }
  TrackedScene scene_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<RotationAlignment> alignment_;
};

TEST_F(Turn, IsFoundFromRestWithAndWithoutColour) {
  for (const bool colour : {true, false}) {
    const auto frame_at = [&](const Se3& T) -> const Frame& {
      return colour ? scene_.color_frame_at(T) : scene_.frame_at(T);
    };
    for (const Se3& T : {turned(0, 0, 0), turned(0, 0.2, 0), turned(0.15, -0.25, 0.05), turned(-0.1, 0, 0.1),
                         turned(0.05, 0.35, -0.05)}) {
      alignment_->keep(frame_at(Se3()));
      const auto found = alignment_->find(frame_at(T), Eigen::Matrix3d::Identity());
      ASSERT_TRUE(found.has_value());
      EXPECT_LT(angle_between(T.rotation(), *found), 0.02) << T.angle() << " colour " << colour;
      EXPECT_LT((*found * found->transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
    }
  }
}

TEST_F(Turn, StaysNearAGuessThatIsRight) {
  const Se3 T = turned(0.1, 0.4, 0.1);
  alignment_->keep(scene_.color_frame_at(Se3()));
  const auto found = alignment_->find(scene_.color_frame_at(T), T.rotation());
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(angle_between(T.rotation(), *found), 0.03);
}

TEST_F(Turn, IsFoundThroughASmallStepAndAChangeOfExposure) {
  const Se3 T(turned(0.05, 0.2, 0).rotation(), Eigen::Vector3d(0.04, 0, 0.05));
  alignment_->keep(scene_.color_frame_at(Se3()));
  const auto found = alignment_->find(scene_.color_frame_at(T, 0.6), Eigen::Matrix3d::Identity());
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(angle_between(T.rotation(), *found), 0.04);
}

TEST_F(Turn, ThereIsNoneWithoutAnythingToCompare) {
  EXPECT_FALSE(alignment_->find(scene_.frame_at(Se3()), Eigen::Matrix3d::Identity())) << "nothing kept yet";
  alignment_->keep(scene_.frame_at(Se3()));
  EXPECT_FALSE(alignment_->find(scene_.black_frame(), Eigen::Matrix3d::Identity())) << "a covered lens";
  alignment_->keep(scene_.black_frame());
  EXPECT_FALSE(alignment_->find(scene_.frame_at(Se3()), Eigen::Matrix3d::Identity())) << "one before";
}

TEST(SmallTurn, ImagesOfAFewPixelsAreNoError) {
  for (const int width : {1, 3, 8}) {
    const PinholeCamera camera{width, width, 8.0F, 8.0F, 0.5F, 0.5F};
    Arena measuring;
    const RotationAlignment unused(camera, measuring);
    Arena arena(measuring.used_bytes() + 64);
    RotationAlignment alignment(camera, arena);
    std::vector<float> depth(64, 2.0F);
    Frame frame;
    frame.level_count = 1;
    frame.levels[0].camera = camera;
    frame.levels[0].depth_m = {depth.data(), width, width};
    alignment.keep(frame);
    EXPECT_EQ(alignment.find(frame, Eigen::Matrix3d::Identity()).has_value(), width == 8) << width;
  }
}

// Directions with a value of their own each, and holes.
struct Directions {
  explicit Directions(const PinholeCamera& camera, double phase) : values(2) {
    images.camera = camera;
    for (std::size_t c = 0; c < 2; ++c) {
      for (int k = 0; k < camera.width * camera.height; ++k) {
        const double value = std::sin(0.7 * k + phase + static_cast<double>(c)) + 0.01 * k;
        values[c].push_back(k % 11 == 3 ? DirectionImages::kNone : static_cast<float>(value));
      }
      images.channel[c] = {values[c].data(), values[c].size()};
    }
  }
  std::vector<std::vector<float>> values;
  DirectionImages images;
};

// The same, pixel by pixel in double precision.
double plain_difference(const Directions& kept, const Directions& present, const Eigen::Matrix3d& R,
                        std::size_t channel) {
  const PinholeCamera &k = kept.images.camera, &p = present.images.camera;
  std::vector<double> differences;
  for (int y = 0; y < p.height; ++y) {
    for (int x = 0; x < p.width; ++x) {
      const Eigen::Vector3d q =
          R * p.unproject(static_cast<float>(x), static_cast<float>(y), 1.0F).cast<double>();
      float pu = 0, pv = 0;
      if (!k.project(q.cast<float>(), &pu, &pv)) continue;
      const auto u = static_cast<int>(std::floor(pu + 0.5F)), v = static_cast<int>(std::floor(pv + 0.5F));
      if (u < 0 || v < 0 || u >= k.width || v >= k.height) continue;
      const float a = kept.values[channel][static_cast<std::size_t>(v * k.width + u)];
      const float b = present.values[channel][static_cast<std::size_t>(y * p.width + x)];
      if (a > DirectionImages::kLeast && b > DirectionImages::kLeast)
        differences.push_back(static_cast<double>(a) - static_cast<double>(b));
    }
  }
  double mean = 0, sum = 0;
  for (const double d : differences) mean += d / static_cast<double>(differences.size());
  for (const double d : differences) sum += std::fabs(d - mean);
  const bool enough = 2 * differences.size() >= static_cast<std::size_t>(p.width * p.height);
  return enough ? sum / static_cast<double>(differences.size()) : -1;
}

TEST(CompareTurned, EqualsThePlainForm) {
  const PinholeCamera camera{20, 15, 16.3F, 16.3F, 9.5F, 7.2F};
  const Directions kept(camera, 0.0), present(camera, 0.4);
  for (const Se3& T : {turned(0, 0, 0), turned(0.05, 0.1, 0), turned(-0.11, 0.13, 0.3), turned(0, 0.9, 0)}) {
    const TurnDifference fast = compare_turned(kept.images, present.images, T.rotation());
    for (std::size_t c = 0; c < 2; ++c)
      EXPECT_NEAR(static_cast<double>(fast.mean[c]), plain_difference(kept, present, T.rotation(), c), 2e-3)
          << T.angle();
  }
  EXPECT_EQ(compare_turned(kept.images, present.images, turned(0, 0.9, 0).rotation()).mean[0], -1.0F)
      << "too little of both is in sight";
}

}  // namespace
}  // namespace loopsift
