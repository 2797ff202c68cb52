// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/evaluation/surface_error.hpp"

namespace loopsift {
namespace {

using testing::HasSubstr;

/// A square of 2 m by 2 m at z = 0, cut along its diagonal.
const std::vector<Eigen::Vector3f> kCorners = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
const std::vector<Eigen::Vector3i> kSquare = {{0, 1, 2}, {0, 2, 3}};

TEST(SampleMesh, SpreadsPointsEvenlyOverTheArea) {
  const auto samples = sample_mesh(kCorners, kSquare, 0.02F, 1000000);
  ASSERT_TRUE(samples.ok());
  EXPECT_NEAR(static_cast<double>(samples->size()), 10000, 2);
  int left = 0, low = 0;
  for (const Eigen::Vector3f& p : *samples) {
    ASSERT_TRUE(p.x() >= 0 && p.x() <= 2 && p.y() >= 0 && p.y() <= 2 && p.z() == 0) << p.transpose();
    left += p.x() < 1 ? 1 : 0;
    low += p.y() < 0.5F ? 1 : 0;
  }
  EXPECT_NEAR(left, 5000, 300);
  EXPECT_NEAR(low, 2500, 250);
  EXPECT_EQ(sample_mesh(kCorners, kSquare, 0.02F, 1000000)->front(), samples->front()) << "a fixed seed";
  EXPECT_NEAR(static_cast<double>(sample_mesh(kCorners, kSquare, 0.02F, 500)->size()), 500, 2);
}

TEST(SampleMesh, WrongMeshesAreRefused) {
  EXPECT_THAT(sample_mesh(kCorners, {}, 0.1F, 10).error().message, HasSubstr("no triangle"));
  const std::vector<Eigen::Vector3i> flat = {{0, 1, 1}};
  EXPECT_THAT(sample_mesh(kCorners, flat, 0.1F, 10).error().message, HasSubstr("no area"));
}

TEST(Completeness, IsTheShareOfTheSurfaceNearTheMap) {
  const auto samples = sample_mesh(kCorners, kSquare, 0.02F, 1000000);
  ASSERT_TRUE(samples.ok());
  std::vector<Eigen::Vector3f> half;  // the half x < 1, 3 cm above
  for (int x = 0; x < 50; ++x)
    for (int y = 0; y <= 100; ++y)
      half.emplace_back(0.02F * static_cast<float>(x), 0.02F * static_cast<float>(y), 0.03F);
  EXPECT_NEAR(completeness(*samples, half, 0.05F).value(), 0.5, 0.04);
  EXPECT_EQ(completeness(*samples, half, 0.02F).value(), 0.0);
  EXPECT_THAT(completeness(*samples, {}, 0.05F).error().message, HasSubstr("map is empty"));
}

}  // namespace
}  // namespace loopsift
