// SPDX-License-Identifier: MIT
#include "core/proposal/registration_cloud.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <tuple>

#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

using test::SurfelCloud;

RegistrationCloud thin(SurfelCloud* surfels, const RegistrationCloudOptions& options = {}) {
  RegistrationCloud cloud;
  VoxelThinner(options).thin(surfels->span(), &cloud);
  return cloud;
}

TEST(VoxelThinner, LeavesOnePointPerVoxel) {
  SurfelCloud surfels = test::furnished_corner(Se3());
  RegistrationCloudOptions options;
  options.max_points = 20000;
  const RegistrationCloud cloud = thin(&surfels, options);
  ASSERT_GT(cloud.size(), 1000U);
  ASSERT_EQ(cloud.points.size(), cloud.normals.size());
  std::set<std::tuple<int, int, int>> voxels;
  for (std::size_t k = 0; k < surfels.size(); ++k)
    voxels.insert({static_cast<int>(std::floor(surfels.x[k] / 0.05F)),
                   static_cast<int>(std::floor(surfels.y[k] / 0.05F)),
                   static_cast<int>(std::floor(surfels.z[k] / 0.05F))});
  EXPECT_NEAR(static_cast<double>(cloud.size()), static_cast<double>(voxels.size()),
              0.01 * static_cast<double>(voxels.size()));
  for (const Eigen::Vector3f& n : cloud.normals) EXPECT_NEAR(n.norm(), 1.0F, 1e-5F);
}

TEST(VoxelThinner, AveragesByWeight) {
  SurfelCloud surfels;
  surfels.add({0.01, 0.01, 0.01}, {0, 0, 1}, 3.0F);
  surfels.add({0.03, 0.01, 0.01}, {0, 0, 1}, 1.0F);
  const RegistrationCloud cloud = thin(&surfels);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud.points[0].x(), 0.015F, 1e-6F);
}

TEST(VoxelThinner, KeepsTheOtherSideOfAThinThingOut) {
  SurfelCloud surfels;
  surfels.add({0.01, 0.01, 0.01}, {0, 0, 1});
  surfels.add({0.01, 0.01, 0.03}, {0, 0, -1});
  const RegistrationCloud cloud = thin(&surfels);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud.points[0].z(), 0.01F, 1e-6F);
  EXPECT_NEAR(cloud.normals[0].z(), 1.0F, 1e-6F);
}

TEST(VoxelThinner, SkipsWhatIsNoSurfel) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  SurfelCloud surfels;
  surfels.add({kNan, 0, 0}, {0, 0, 1});
  surfels.add({0, 0, 1e30}, {0, 0, 1});
  surfels.add({0, 0, 1}, {0, 0, 0});
  surfels.add({0, 0, 1}, {kNan, 0, 1});
  surfels.add({0, 0, 1}, {0, 0, 1}, 0.0F);
  EXPECT_EQ(thin(&surfels).size(), 0U);
}

TEST(VoxelThinner, StopsAtItsCapacityAndRecovers) {
  SurfelCloud surfels = test::furnished_corner(Se3());
  RegistrationCloudOptions options;
  options.max_points = 200;
  VoxelThinner thinner(options);
  RegistrationCloud cloud;
  thinner.thin(surfels.span(), &cloud);
  EXPECT_EQ(cloud.size(), 200U);
  SurfelCloud single;
  single.add({1, 2, 3}, {0, 0, 1});
  thinner.thin(single.span(), &cloud);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud.points[0].z(), 3.0F, 1e-6F);
}

}  // namespace
}  // namespace loopsift
