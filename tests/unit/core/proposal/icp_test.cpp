// SPDX-License-Identifier: MIT
#include "core/proposal/icp.hpp"

#include <gtest/gtest.h>

#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

/// A target with its index, and the same surface as a source, seen from elsewhere.
struct Pair {
  RegistrationCloud target_cloud, source;
  NearestField field;
  [[nodiscard]] IcpTarget target() const { return {&target_cloud, &field}; }

  Pair(test::SurfelCloud target_surfels, test::SurfelCloud source_surfels) {
    VoxelThinner thinner{RegistrationCloudOptions()};
    thinner.thin(target_surfels.span(), &target_cloud);
    thinner.thin(source_surfels.span(), &source);
    field.build(target_cloud.points, 0.2F, 0.05F, 1 << 20);
  }
};

const Se3 kTruth = test::motion(0.4, -0.3, 0.2, 0.1, -0.2, 0.9);

Pair corner_seen_twice() { return {test::furnished_corner(Se3()), test::furnished_corner(kTruth)}; }

double cost_at(const Pair& pair, const Se3& T, Loss loss) {
  return point_to_plane_system(IcpOptions(), pair.target(), pair.source, T, 0.2F, 1, loss).cost;
}

/// Partners must not change while differences are taken: a source of single points, each beside its own
/// plane.
Pair separate_patches() {
  test::SurfelCloud target, source;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d p(0.35 * (k % 4) + 0.02, 0.35 * (k / 4 % 4) + 0.02, 0.35 * (k / 16) + 0.02);
    const Eigen::Vector3d n =
        Eigen::Vector3d(std::sin(2.0 * k), std::cos(3.0 * k), std::sin(5.0 * k)).normalized();
    target.add(p, n);
    source.add(p + 0.004 * (1 + k % 3) * n, n);
  }
  return {target, source};
}

TEST(PointToPlane, GradientMatchesTheCostNumerically) {
  const Pair pair = separate_patches();
  const Se3 T = test::motion(0.01, -0.005, 0.008, 0.004, 0.003, -0.006);
  for (const Loss loss : {Loss::kSquared, Loss::kGemanMcClure}) {
    const PointToPlaneSystem system =
        point_to_plane_system(IcpOptions(), pair.target(), pair.source, T, 0.2F, 1, loss);
    ASSERT_EQ(system.partners, 40);
    constexpr double kStep = 1e-3;
    for (int a = 0; a < 6; ++a) {
      const Vector6d xi = kStep * Vector6d::Unit(a);
      const double numeric =
          (cost_at(pair, T * Se3::exp(xi), loss) - cost_at(pair, T * Se3::exp(-xi), loss)) / (2 * kStep);
      EXPECT_NEAR(system.g(a), numeric, 0.01 * system.g.norm()) << a;
    }
  }
}

TEST(PointToPlane, HessianMatchesTheCostNumerically) {
  const Pair pair = separate_patches();
  const PointToPlaneSystem system =
      point_to_plane_system(IcpOptions(), pair.target(), pair.source, Se3(), 0.2F, 1, Loss::kSquared);
  constexpr double kStep = 5e-3;
  const auto cost = [&](const Vector6d& xi) { return cost_at(pair, Se3::exp(xi), Loss::kSquared); };
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      const Vector6d u = kStep * Vector6d::Unit(a), v = kStep * Vector6d::Unit(b);
      const double numeric = (cost(u + v) - cost(u - v) - cost(v - u) + cost(-u - v)) / (4 * kStep * kStep);
      EXPECT_NEAR(system.H(a, b), numeric, 0.03 * std::sqrt(system.H(a, a) * system.H(b, b)))
          << a << " " << b;
    }
  }
}

TEST(PointToPlane, FarSurfacesWeighLess) {
  test::SurfelCloud near, far;
  near.add({0, 0, 1}, {0, 0, -1});
  far.add({0, 0, 4}, {0, 0, -1});
  const Pair one(near, near), four(far, far);
  const auto weight = [](const Pair& pair) {
    return point_to_plane_system(IcpOptions(), pair.target(), pair.source, Se3(), 0.2F, 1, Loss::kSquared)
        .H(2, 2);
  };
  // σ = 5 mm + 4 mm/m² d²: 9 mm and 69 mm.
  EXPECT_NEAR(weight(one), 1 / (2 * 0.009 * 0.009), 1);
  EXPECT_NEAR(weight(four), 1 / (2 * 0.069 * 0.069), 1e-2);
}

TEST(Refine, BringsANearStartHome) {
  const Pair pair = corner_seen_twice();
  const IcpResult result = refine(IcpOptions(), pair.target(), pair.source,
                                  kTruth * test::motion(0.06, -0.05, 0.04, 0.03, -0.03, 0.04));
  ASSERT_TRUE(result.ok);
  const Vector6d error = (kTruth.inverse() * result.T_target_source).log();
  EXPECT_LT(error.head<3>().norm(), 0.003);
  EXPECT_LT(error.tail<3>().norm(), 0.003);
  EXPECT_LT(result.residual_m, 0.005F);
  EXPECT_GT(result.partners, static_cast<int>(0.95 * static_cast<double>(pair.source.size())));
}

TEST(Refine, InformationIsSymmetricPositiveAndMatchesTheSystem) {
  const Pair pair = corner_seen_twice();
  const IcpOptions options;
  const IcpResult result = refine(options, pair.target(), pair.source, kTruth);
  ASSERT_TRUE(result.ok);
  const Matrix6d& L = result.information;
  EXPECT_LT((L - L.transpose()).norm(), 1e-6 * L.norm());
  const PointToPlaneSystem system =
      point_to_plane_system(options, pair.target(), pair.source, result.T_target_source,
                            options.stages.back().max_distance_m, 1, Loss::kSquared);
  // Residuals are smaller than the weights claim here, so nothing but the correlation scales the system.
  EXPECT_LT((L * static_cast<double>(options.correlated_pairs) - system.H).norm(), 1e-6 * system.H.norm());
}

TEST(Refine, InformationFallsWhereResidualsExceedTheWeights) {
  const Pair pair = corner_seen_twice();
  IcpOptions confident;
  confident.sigma_floor_m = 1e-5F;
  confident.sigma_slope_per_m = 0;
  const IcpResult result = refine(confident, pair.target(), pair.source, kTruth);
  ASSERT_TRUE(result.ok);
  const PointToPlaneSystem system =
      point_to_plane_system(confident, pair.target(), pair.source, result.T_target_source,
                            confident.stages.back().max_distance_m, 1, Loss::kSquared);
  const double variance_factor = 2 * system.cost / system.partners;
  ASSERT_GT(variance_factor, 2.0);
  EXPECT_LT((result.information * variance_factor * 50 - system.H).norm(), 1e-6 * system.H.norm());
}

TEST(Refine, APlaneAloneIsNotDetermined) {
  const Pair pair(test::flat_floor(), test::flat_floor());
  EXPECT_FALSE(refine(IcpOptions(), pair.target(), pair.source, Se3()).ok);
}

TEST(Refine, FailsFarFromTheTargetOnOtherSidesAndOnNothing) {
  const Pair pair = corner_seen_twice();
  EXPECT_FALSE(refine(IcpOptions(), pair.target(), pair.source, test::motion(50, 0, 0, 0, 0, 0)).ok);
  Pair inside_out = corner_seen_twice();
  for (Eigen::Vector3f& n : inside_out.source.normals) n = -n;
  EXPECT_FALSE(refine(IcpOptions(), inside_out.target(), inside_out.source, kTruth).ok);
  EXPECT_FALSE(refine(IcpOptions(), pair.target(), RegistrationCloud(), Se3()).ok);
  const Pair empty{test::SurfelCloud(), test::SurfelCloud()};
  EXPECT_FALSE(refine(IcpOptions(), empty.target(), pair.source, Se3()).ok);
}

}  // namespace
}  // namespace loopsift
