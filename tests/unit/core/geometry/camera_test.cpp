// SPDX-License-Identifier: MIT
#include "core/geometry/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace loopsift {
namespace {

constexpr PinholeCamera kKinect{640, 480, 585.0F, 580.0F, 319.5F, 239.5F};
// Half a turn of columns, 30° up to 30° down.
constexpr SphericalCamera kLidar{512, 64, -1.57F, 3.14F / 512.0F, -0.52F, 1.04F / 64.0F};

template <class Camera>
void expect_round_trip(const Camera& camera, float u, float v, float depth) {
  const Eigen::Vector3f p = camera.unproject(u, v, depth);
  EXPECT_NEAR(camera.depth(p), depth, 1e-5F * depth);
  float u2 = 0, v2 = 0;
  ASSERT_TRUE(camera.project(p, &u2, &v2));
  EXPECT_NEAR(u2, u, 2e-3F);
  EXPECT_NEAR(v2, v, 2e-3F);
}

TEST(Camera, ProjectInvertsUnproject) {
  for (const float depth : {0.3F, 1.0F, 12.0F}) {
    for (const float u : {0.0F, 17.25F, 319.5F, 511.0F}) {
      for (const float v : {0.0F, 31.5F, 63.0F}) {
        expect_round_trip(kKinect, u, v, depth);
        expect_round_trip(kLidar, u, v, depth);
      }
    }
  }
}

TEST(Camera, PinholeProjectsByItsDefinition) {
  float u = 0, v = 0;
  ASSERT_TRUE(kKinect.project({0.5F, -0.25F, 2.0F}, &u, &v));
  EXPECT_FLOAT_EQ(u, 585.0F * 0.25F + 319.5F);
  EXPECT_FLOAT_EQ(v, 580.0F * -0.125F + 239.5F);
}

TEST(Camera, NothingBehindOrInThePinholeIsSeen) {
  float u = 0, v = 0;
  EXPECT_FALSE(kKinect.project({0, 0, -1}, &u, &v));
  EXPECT_FALSE(kKinect.project({0, 0, 0}, &u, &v));
  EXPECT_FALSE(kKinect.project({0, 0, std::nanf("")}, &u, &v));
  EXPECT_FALSE(kLidar.project({0, 0, 0}, &u, &v));
}

TEST(Camera, ContainsReachesHalfAPixelPastTheCentres) {
  EXPECT_TRUE(kKinect.contains(-0.5F, -0.5F));
  EXPECT_TRUE(kKinect.contains(639.4F, 479.4F));
  EXPECT_FALSE(kKinect.contains(639.5F, 0));
  EXPECT_FALSE(kKinect.contains(0, -0.6F));
}

TEST(Camera, SubsampledSeesTheSameRayAtEachKeptPixel) {
  for (const int offset : {0, 1, 2}) {
    const PinholeCamera reduced = kKinect.subsampled(4, offset);
    EXPECT_EQ(reduced.width, 160);
    EXPECT_EQ(reduced.height, 120);
    const Eigen::Vector3f full =
        kKinect.unproject(static_cast<float>(4 * 30 + offset), static_cast<float>(4 * 70 + offset), 2.0F);
    EXPECT_LT((reduced.unproject(30, 70, 2.0F) - full).norm(), 1e-5F);
  }
}

TEST(Camera, SubsampledCountsThePixelsThatAreThere) {
  const PinholeCamera odd{641, 483, 500, 500, 320, 240};
  EXPECT_EQ(odd.subsampled(4, 0).width, 161);   // columns 0, 4, …, 640
  EXPECT_EQ(odd.subsampled(4, 1).width, 160);   // columns 1, 5, …, 637
  EXPECT_EQ(odd.subsampled(4, 2).height, 121);  // rows 2, 6, …, 482
}

TEST(Camera, BlockAveragedLooksThroughTheMiddleOfEachBlock) {
  const PinholeCamera reduced = kKinect.block_averaged(2);
  const Eigen::Vector3f middle = kKinect.unproject(2 * 50 + 0.5F, 2 * 20 + 0.5F, 1.0F);
  EXPECT_LT((reduced.unproject(50, 20, 1.0F) - middle).norm(), 1e-5F);
}

TEST(Camera, IsValidRefusesMissingOrBrokenIntrinsics) {
  EXPECT_TRUE(kKinect.is_valid());
  EXPECT_FALSE(PinholeCamera().is_valid());
  EXPECT_FALSE((PinholeCamera{640, 480, -1, 1, 1, 1}).is_valid());
  EXPECT_FALSE((PinholeCamera{640, 480, 1, 1, NAN, 1}).is_valid());
}

}  // namespace
}  // namespace loopsift
