// SPDX-License-Identifier: MIT
#include "core/odometry/photometric.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/unit/core/odometry/tracked_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::TrackedScene;

Se3 moved(double tx, double ty, double tz, double rx, double ry, double rz) {
  Vector6d xi;
  xi << tx, ty, tz, rx, ry, rz;
  return Se3::exp(xi);
}

class Photometric : public testing::Test {
 protected:
  Photometric() : scene_(AnalyticScene::room(), 2) {
    const Frame& frame = scene_.color_frame_at(Se3());
    Arena measuring;
    const Keyframe unused(scene_.working_camera(), frame.level_count, measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    key_ = std::make_unique<Keyframe>(scene_.working_camera(), frame.level_count, *arena_);
    key_->keep(frame, Se3());
  }
  TrackedScene scene_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Keyframe> key_;
};

// The same system, pixel by pixel in double precision.
PhotometricSystem plain(const FrameLevel& level, const Keyframe::Level& key, const Se3& T,
                        const PhotometricSettings& set) {
  Eigen::Matrix<double, 7, 7> H = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> b = Eigen::Matrix<double, 7, 1>::Zero();
  PhotometricSystem system;
  const PinholeCamera& c = level.camera;
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const float z = key.depth_m(x, y);
      if (z <= 0) continue;
      const Eigen::Vector3d q =
          T * key.camera.unproject(static_cast<float>(x), static_cast<float>(y), z).cast<double>();
      const double u = static_cast<double>(c.fx) * q.x() / q.z() + static_cast<double>(c.cx);
      const double v = static_cast<double>(c.fy) * q.y() / q.z() + static_cast<double>(c.cy);
      if (u < 0 || v < 0 || u >= c.width - 1 || v >= c.height - 1) continue;
      const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
      const double s = u - u0, t = v - v0;
      const auto at = [&](int i, int j) { return static_cast<double>(level.intensity(u0 + i, v0 + j)); };
      const auto measured =
          static_cast<double>(level.depth_m(s >= 0.5 ? u0 + 1 : u0, t >= 0.5 ? v0 + 1 : v0));
      if (measured <= 0 ||
          std::fabs(measured - q.z()) >= static_cast<double>(set.depth_gate_m) + 0.03 * q.z())
        continue;
      const double gx = (1 - t) * (at(1, 0) - at(0, 0)) + t * (at(1, 1) - at(0, 1));
      const double gy = (1 - s) * (at(0, 1) - at(0, 0)) + s * (at(1, 1) - at(1, 0));
      const double value =
          (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
      const double r = value - static_cast<double>(key.intensity(x, y)) - static_cast<double>(set.exposure);
      const double scale = static_cast<double>(set.scale), w = 6 / (5 + r * r / (scale * scale));
      const Eigen::Vector3d g(
          gx * static_cast<double>(c.fx) / q.z(), gy * static_cast<double>(c.fy) / q.z(),
          -(gx * static_cast<double>(c.fx) * q.x() + gy * static_cast<double>(c.fy) * q.y()) /
              (q.z() * q.z()));
      Eigen::Matrix<double, 7, 1> J;
      J << -g, -q.cross(g), -1;
      H += w * J * J.transpose() / (scale * scale);
      b += w * J * r / (scale * scale);
      ++system.seen;
    }
  }
  system.H = H.topLeftCorner<6, 6>() - H.block<6, 1>(0, 6) * H.block<1, 6>(6, 0) / H(6, 6);
  system.b = b.head<6>() - H.block<6, 1>(0, 6) * b[6] / H(6, 6);
  return system;
}

TEST_F(Photometric, EqualsThePlainForm) {
  const Frame& frame = scene_.color_frame_at(moved(0.02, -0.01, 0.03, 0.01, 0.02, -0.01));
  const PhotometricSettings settings{0.1F, 0.05F, 0.02F};
  for (int l = 0; l < frame.level_count; ++l) {
    const FrameLevel& level = frame.levels[static_cast<std::size_t>(l)];
    const Se3 T = moved(-0.015, 0.01, -0.02, -0.01, -0.015, 0.01);
    const PhotometricSystem fast = linearize_photometric(level, key_->level(l), T, settings);
    const PhotometricSystem slow = plain(level, key_->level(l), T, settings);
    EXPECT_GT(fast.seen, 1000);
    EXPECT_NEAR(fast.seen, slow.seen, 0.002 * slow.seen + 2);
    EXPECT_LT((fast.H - slow.H).norm(), 5e-3 * slow.H.norm());
    EXPECT_LT((fast.b - slow.b).norm(), 2e-2 * slow.b.norm());
  }
}

TEST_F(Photometric, StepsTowardTheTrueMotion) {
  const Vector6d motion = moved(0.02, 0.01, -0.02, 0.01, -0.01, 0.01).log();
  const Frame& frame = scene_.color_frame_at(Se3::exp(motion));
  Se3 T_key_camera;
  PhotometricSettings settings;
  for (int i = 0; i < 8; ++i) {
    const PhotometricSystem system =
        linearize_photometric(frame.levels[0], key_->level(0), T_key_camera.inverse(), settings);
    T_key_camera = T_key_camera * Se3::exp(-system.H.ldlt().solve(system.b));
    settings.scale = std::max(system.scale, 0.01F);
    settings.exposure = system.exposure;
  }
  EXPECT_LT((T_key_camera.log() - motion).norm(), 0.003);
}

// Twice as much light is ln 2 on everything, but for what the dark level takes off; the motion stays.
TEST_F(Photometric, FindsTheExposure) {
  const Frame& brighter = scene_.color_frame_at(Se3(), 1.3);
  const PhotometricSystem system =
      linearize_photometric(brighter.levels[0], key_->level(0), Se3(), PhotometricSettings());
  EXPECT_NEAR(system.exposure, std::log(1.3), 0.06);
}

TEST_F(Photometric, PointsOutOfSightSayNothing) {
  const Frame& frame = scene_.color_frame_at(Se3());
  const PhotometricSystem away = linearize_photometric(frame.levels[0], key_->level(0),
                                                       moved(0, 0, 0, 0, M_PI, 0), PhotometricSettings());
  EXPECT_EQ(away.seen, 0);
  EXPECT_EQ(away.H.norm(), 0.0);
}

}  // namespace
}  // namespace loopsift
