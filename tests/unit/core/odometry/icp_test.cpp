// SPDX-License-Identifier: MIT
#include "core/odometry/icp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "tests/support/analytic_scene.hpp"
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

// The same system, pixel by pixel in double precision.
IcpSystem plain_linearize(const FrameLevel& level, const ModelView& m, const Se3& T, const IcpSettings& set) {
  IcpSystem sum;
  for (int y = 0; y < level.camera.height; ++y) {
    for (int x = 0; x < level.camera.width; ++x) {
      const float z = level.depth_m(x, y);
      const Eigen::Vector3d n_frame =
          Eigen::Vector3f(level.nx(x, y), level.ny(x, y), level.nz(x, y)).cast<double>();
      if (z <= 0 || n_frame.norm() < 0.5) continue;
      ++sum.valid;
      const Eigen::Vector3d p =
          T * level.camera.unproject(static_cast<float>(x), static_cast<float>(y), z).cast<double>();
      float u = 0, v = 0;
      if (!m.camera.project(p.cast<float>(), &u, &v) || !m.camera.contains(u, v)) continue;
      const int mu = static_cast<int>(std::floor(u + 0.5F)), mv = static_cast<int>(std::floor(v + 0.5F));
      if (m.z(mu, mv) <= 0) continue;
      const Eigen::Vector3d q = Eigen::Vector3f(m.x(mu, mv), m.y(mu, mv), m.z(mu, mv)).cast<double>();
      const Eigen::Vector3d n = Eigen::Vector3f(m.nx(mu, mv), m.ny(mu, mv), m.nz(mu, mv)).cast<double>();
      const double sigma = static_cast<double>(depth_sigma(z, set.noise_floor_m, set.noise_slope));
      const double gate = static_cast<double>(set.gate_m) + 3 * sigma;
      if ((p - q).norm() >= gate) continue;
      if (n.dot(T.rotation() * n_frame) <= static_cast<double>(set.min_normal_cosine)) continue;
      const double r = n.dot(p - q), s = static_cast<double>(set.scale);
      const double scaled = r * r / (sigma * sigma), robust = 6 / (5 + scaled / (s * s));
      const double w = robust / (sigma * sigma * s * s);
      Vector6d J;
      J << n, p.cross(n);
      sum.H += w * J * J.transpose();
      sum.b += w * J * r;
      Vector6d K;
      K << T.rotation() * n_frame, p.cross(T.rotation() * n_frame);
      sum.crossed += 0.5 * w * (J * K.transpose() + K * J.transpose());
      sum.weight += robust;
      sum.scaled_squares += robust * scaled;
      ++sum.partners;
      if (scaled < 9 * s * s) ++sum.inliers, sum.squares_m2 += r * r;
    }
  }
  return sum;
}

TEST(Icp, EqualsThePlainForm) {
  TrackedScene scene(AnalyticScene::room(), 2, 0.001, 0.002);
  const ModelView model = scene.model_at(Se3());
  const Frame& frame = scene.frame_at(moved(0.02, -0.01, 0.03, 0.01, 0.02, -0.01));
  for (int l = 0; l < frame.level_count; ++l) {
    const FrameLevel& level = frame.levels[static_cast<std::size_t>(l)];
    const IcpSettings settings{0.08F, 0.5F, 0.0012F, 0.002F, 1.5F};
    const Se3 T = moved(0.005, 0.004, -0.01, 0.002, 0.001, 0.01);
    const IcpSystem fast = linearize(level, model, T, settings),
                    plain = plain_linearize(level, model, T, settings);
    EXPECT_EQ(fast.valid, plain.valid);
    // Single precision may put a few borderline pixels on the other side of a gate.
    EXPECT_NEAR(fast.partners, plain.partners, 0.001 * plain.partners + 2);
    EXPECT_NEAR(fast.inliers, plain.inliers, 0.001 * plain.inliers + 2);
    EXPECT_LT((fast.H - plain.H).norm(), 2e-3 * plain.H.norm());
    EXPECT_LT((fast.crossed - plain.crossed).norm(), 2e-3 * plain.crossed.norm());
    EXPECT_LT((fast.b - plain.b).norm(), 2e-2 * plain.b.norm());
    EXPECT_NEAR(fast.scaled_squares, plain.scaled_squares, 5e-3 * plain.scaled_squares);
    EXPECT_NEAR(fast.squares_m2, plain.squares_m2, 1e-2 * plain.squares_m2);
  }
}

// b must be half the gradient of Σ w r². A huge scale makes the weights constant; on planes the residual does
// not depend on which point of the plane is the partner.
TEST(Icp, GradientEqualsNumericDifferences) {
  const Eigen::Vector3d n1 = Eigen::Vector3d(0.2, 0.1, -1).normalized();
  TrackedScene scene({{{n1, -1.6}}, {}}, 2);
  const ModelView model = scene.model_at(Se3());
  const FrameLevel level = scene.frame_at(moved(0.01, 0.02, 0.015, 0.01, -0.01, 0.02)).levels[0];
  IcpSettings settings;
  settings.gate_m = 0.5F;
  settings.scale = 1e3F;
  const IcpSystem at = linearize(level, model, Se3(), settings);
  const double step = 1e-3, s2 = 1e6;
  for (int k = 0; k < 6; ++k) {
    Vector6d xi = Vector6d::Zero();
    xi[k] = step;
    const double plus = linearize(level, model, Se3::exp(xi), settings).scaled_squares / s2;
    const double minus = linearize(level, model, Se3::exp(-xi), settings).scaled_squares / s2;
    EXPECT_NEAR(at.b[k], 0.5 * (plus - minus) / (2 * step), 0.02 * at.b.norm()) << "component " << k;
  }
}

// Normals of a noisy wall lean this way and that, which looks like knowledge of sideways motion.
TEST(Icp, CrossedInformationLeavesTheNoiseOfTheNormalsOut) {
  TrackedScene noisy(AnalyticScene::wall(), 2, 0.004, 0.002);
  std::vector<float> kept[6];
  ModelView model = noisy.model_at(Se3());
  const Frame& frame = noisy.frame_at(Se3());
  const FrameLevel& level = frame.levels[0];
  // A model as noisy as a single frame.
  const ImageView<const float>* normals[3] = {&level.nx, &level.ny, &level.nz};
  ImageView<const float>* targets[3] = {&model.nx, &model.ny, &model.nz};
  for (int k = 0; k < 3; ++k) {
    kept[k].assign(normals[k]->data, normals[k]->data + normals[k]->size());
    targets[k]->data = kept[k].data();
  }
  const IcpSystem system = linearize(noisy.frame_at(Se3()).levels[0], model, Se3(), IcpSettings());
  EXPECT_GT(system.H(0, 0), 0.001 * system.H(2, 2));
  EXPECT_LT(std::fabs(system.crossed(0, 0)), 0.2 * system.H(0, 0));
  EXPECT_GT(system.crossed(2, 2), 0.9 * system.H(2, 2));
}

TEST(Icp, PixelsWithoutModelHaveNoPartner) {
  TrackedScene scene(AnalyticScene::room(), 2);
  const ModelView model = scene.model_at(Se3());
  const IcpSystem away =
      linearize(scene.frame_at(Se3()).levels[0], model, moved(0, 0, 0, 0, M_PI, 0), IcpSettings());
  EXPECT_GT(away.valid, 1000);
  EXPECT_EQ(away.partners, 0);
  EXPECT_EQ(away.H.norm(), 0.0);
}

}  // namespace
}  // namespace loopsift
