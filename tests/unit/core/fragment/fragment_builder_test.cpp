// SPDX-License-Identifier: MIT
#include "core/fragment/fragment_builder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/core/fragment/fused_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::FusedScene;
using test::shifted;
using test::small_camera;

TEST(Fusion, AveragesNoise) {
  FusedScene fused(AnalyticScene::room());
  const Se3 T;
  for (int i = 0; i < 3; ++i) fused.add(T, 0.003, 0.004);
  const double early = fused.median_error(fused.builder().active().surfels(), T);
  for (int i = 3; i < 30; ++i) fused.add(T, 0.003, 0.004);
  const double late = fused.median_error(fused.builder().active().surfels(), T);
  EXPECT_LT(late, 0.5 * early) << "ten times the frames: √10 would be 0.32";
  const Fragment* closed = fused.builder().close(&fused.store());
  EXPECT_LT(fused.surface_error(closed->surfels, T), 0.004);
}

TEST(Fusion, DoublesNoSurface) {
  FusedScene fused(AnalyticScene::room());
  fused.add(Se3(), 0.002, 0.002);
  const std::size_t first = fused.builder().active().surfels().size();
  for (int i = 1; i < 20; ++i) fused.add(shifted(0.004 * i, 0, 0.002 * i, 0.002 * i), 0.002, 0.002);
  // The camera moved 8 cm: a little more is in sight, nothing is there twice.
  EXPECT_LT(static_cast<double>(fused.builder().active().surfels().size()),
            1.35 * static_cast<double>(first));
  const Fragment* closed = fused.builder().close(&fused.store());
  ASSERT_NE(closed, nullptr);
  EXPECT_LT(fused.surface_error(closed->surfels, closed->T_odom_fragment), 0.004);
}

TEST(Fusion, RemovesWhatTheCameraSeesThrough) {
  FusedScene fused(AnalyticScene::room());
  fused.scene.spheres = {{Eigen::Vector3d(0, 0, 1.0), 0.2}};
  for (int i = 0; i < 10; ++i) fused.add(Se3());
  const auto near_sphere = [&](const SurfelSpan& s) {
    int count = 0;
    for (std::size_t i = 0; i < s.size(); ++i)
      count += Eigen::Vector3f(s.x[i], s.y[i], s.z[i] - 1.0F).norm() < 0.21F ? 1 : 0;
    return count;
  };
  const int before = near_sphere(fused.builder().active().surfels());
  EXPECT_GT(before, 500);
  fused.scene.spheres.clear();
  for (int i = 10; i < 40; ++i) fused.add(Se3());
  EXPECT_LT(near_sphere(fused.builder().close(&fused.store())->surfels), before / 50);
}

TEST(Fusion, KeepsTwoSidesOfAThinThingApart) {
  // A plate 1 cm thick, half a thinning cell: one side seen from the front, the other from behind.
  AnalyticScene plate{{{Eigen::Vector3d(0, 0, -1), -1.5}, {Eigen::Vector3d(0, 0, 1), 1.51}}, {}};
  FusedScene fused(plate);
  const Se3 behind(so3_exp(Eigen::Vector3d(0, M_PI, 0)), Eigen::Vector3d(0, 0, 3.0));
  for (int i = 0; i < 5; ++i) fused.add(Se3());
  for (int i = 0; i < 5; ++i) fused.add(behind);
  const Fragment* closed = fused.builder().close(&fused.store());
  int front = 0, back = 0;
  for (std::size_t i = 0; i < closed->surfels.size(); ++i) {
    const bool faces_front = closed->surfels.nz[i] < 0;
    ++(faces_front ? front : back);
    ASSERT_NEAR(closed->surfels.z[i], faces_front ? 1.5F : 1.51F, 0.002F);
  }
  EXPECT_GT(front, 1000);
  EXPECT_GT(back, 1000);
}

TEST(Fusion, DropsWhatFewFramesSaw) {
  FusedScene fused(AnalyticScene::wall());
  for (int i = 0; i < 10; ++i) {
    if (i == 4) fused.scene.spheres = {{Eigen::Vector3d(0, 0, 1.0), 0.2}};
    if (i == 5) fused.scene.spheres.clear();
    fused.add(Se3());
  }
  const Fragment* closed = fused.builder().close(&fused.store());
  for (std::size_t i = 0; i < closed->surfels.size(); ++i) ASSERT_GT(closed->surfels.z[i], 1.9F);
}

TEST(Fusion, TakesColourFromAnImageOfAnotherSize) {
  FusedScene fused(AnalyticScene::wall());
  std::vector<Rgb8> color(static_cast<std::size_t>(64) * 48, Rgb8{10, 200, 30});
  for (int y = 0; y < 48; ++y)
    for (int x = 32; x < 64; ++x) color[static_cast<std::size_t>(y * 64 + x)] = {250, 20, 90};
  for (int i = 0; i < 4; ++i) {
    RawFrame raw = fused.camera.capture(fused.scene, Se3());
    raw.color = {color.data(), 64, 48};
    fused.builder().integrate(fused.preprocess(raw), Se3(), Matrix6d::Identity(), true);
  }
  const Fragment* closed = fused.builder().close(&fused.store());
  for (std::size_t i = 0; i < closed->surfels.size(); ++i) {
    const float x = closed->surfels.x[i];
    if (std::fabs(x) > 0.05F) {
      ASSERT_EQ(closed->surfels.rgb[i], x < 0 ? 0x0AC81EU : 0xFA145AU);
    }
  }
}

TEST(Fusion, FullSurfelPoolIsCountedAndHarmless) {
  FragmentOptions options;
  options.active_capacity = 1000;
  FusedScene fused(AnalyticScene::room(), options);
  for (int i = 0; i < 5; ++i) fused.add(Se3());
  EXPECT_EQ(fused.builder().active().surfels().size(), 1000U);
  EXPECT_EQ(fused.builder().active().high_water(), 1000U);
  EXPECT_GT(fused.builder().active().refused(), 1000U);
  EXPECT_NE(fused.builder().close(&fused.store()), nullptr);
}

TEST(FragmentBuilder, ClosesWithFramesViewsAndItsOwnFrame) {
  FragmentOptions options;
  options.frames_per_fragment = 12;
  options.views_per_fragment = 3;
  options.view_step = 4;
  FusedScene fused(AnalyticScene::room(), options);
  EXPECT_TRUE(fused.builder().empty());
  EXPECT_EQ(fused.builder().close(&fused.store()), nullptr) << "nothing in it";
  std::vector<std::uint16_t> seen_by_view_1;
  for (int i = 0; i < 12; ++i) {
    EXPECT_FALSE(fused.builder().full());
    fused.add(shifted(1.0 + 0.01 * i, 0, 0));
    if (i == 4) seen_by_view_1 = fused.camera.pixels();
  }
  EXPECT_TRUE(fused.builder().full());
  const Fragment* closed = fused.builder().close(&fused.store());
  ASSERT_NE(closed, nullptr);
  EXPECT_TRUE(fused.builder().empty());
  EXPECT_TRUE(closed->joined_to_previous);
  ASSERT_EQ(closed->frames.size(), 12U);
  EXPECT_DOUBLE_EQ(closed->T_odom_fragment.translation().x(), 1.0);
  EXPECT_NEAR(closed->frames[11].T_fragment_camera.translation().x(), 0.11, 1e-12);
  EXPECT_EQ(closed->frames[11].frame, FrameId{11});
  ASSERT_EQ(closed->views.size(), 3U);
  EXPECT_EQ(closed->views[1].frame_in_fragment, 4);
  EXPECT_NEAR(closed->views[1].T_fragment_camera.translation().x(), 0.04, 1e-12);
  const ScoreView& view = closed->views[1];
  EXPECT_EQ(view.depth_m.width, 80);
  EXPECT_EQ(view.depth_m.height, 60);
  for (int y = 0; y < 60; y += 7)
    for (int x = 0; x < 80; x += 7)
      ASSERT_FLOAT_EQ(
          view.depth_m(x, y),
          static_cast<float>(seen_by_view_1[static_cast<std::size_t>((4 * y + 2) * 320 + 4 * x + 2)]) *
              static_cast<float>(test::SceneCamera::kUnitM));
  EXPECT_FLOAT_EQ(view.camera.cx, small_camera().subsampled(4, 2).cx);
}

TEST(FragmentBuilder, ViewsHoldNoDepthOutsideTheRange) {
  FusedScene fused(AnalyticScene::wall());  // 2 m away
  const FrameOptions range;
  RawFrame raw = fused.camera.capture(fused.scene, Se3());
  std::vector<std::uint16_t> pixels = fused.camera.pixels();
  const auto raw_of = [](float metres) {
    return static_cast<std::uint16_t>(metres / static_cast<float>(test::SceneCamera::kUnitM));
  };
  const std::uint16_t outside[] = {raw_of(0.5F * range.min_depth_m), raw_of(range.max_depth_m + 0.5F), 65535};
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (i % 5 < 3) pixels[i] = outside[i % 5];
  raw.depth = {pixels.data(), raw.depth.width, raw.depth.height};
  fused.builder().integrate(fused.preprocess(raw), Se3(), Matrix6d::Identity(), true);
  const Fragment* closed = fused.builder().close(&fused.store());
  ASSERT_NE(closed, nullptr);
  const ImageView<const float>& view = closed->views[0].depth_m;
  int inside = 0;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      if (view(x, y) == 0.0F) continue;
      ++inside;
      ASSERT_GE(view(x, y), range.min_depth_m);
      ASSERT_LE(view(x, y), range.max_depth_m);
    }
  EXPECT_GT(inside, 0);
  EXPECT_LT(inside, view.width * view.height);
}

TEST(FragmentBuilder, ThinsUntilTheFragmentFits) {
  FragmentOptions options;
  options.max_surfels = 700;
  FusedScene fused(AnalyticScene::room(), options);
  for (int i = 0; i < 4; ++i) fused.add(Se3());
  const Fragment* closed = fused.builder().close(&fused.store());
  EXPECT_LE(closed->surfels.size(), 700U);
  EXPECT_GT(closed->surfels.size(), 200U);
  for (std::size_t i = 0; i < closed->surfels.size(); ++i)
    ASSERT_NEAR(std::hypot(closed->surfels.nx[i], closed->surfels.ny[i], closed->surfels.nz[i]), 1.0F, 1e-4F);
}

// Steps of 3 cm and 20 mrad, each known to 1 cm; frames until it is time to close.
int frames_until_full(const FragmentOptions& options) {
  FusedScene fused(AnalyticScene::room(), options);
  for (int i = 0;; ++i) {
    if (fused.builder().full()) return i;
    fused.add_with(shifted(0.03 * i, 0, 0, 0.02 * i), 1e4 * Matrix6d::Identity());
  }
}

TEST(FragmentBuilder, ClosesByFramesWayTurnOrDriftWhicheverComesFirst) {
  FragmentOptions options;
  options.frames_per_fragment = 20;
  EXPECT_EQ(frames_until_full(options), 20);
  options.max_travel_m = 0.5F;  // 16 steps are 0.48 m
  EXPECT_EQ(frames_until_full(options), 18);
  options.max_turn_rad = 0.25F;  // 12 steps are 0.24 rad
  EXPECT_EQ(frames_until_full(options), 14);
  options.max_drift_m = 0.025F;  // 6 steps are 2.4 cm
  EXPECT_EQ(frames_until_full(options), 8);
  options.max_travel_m = options.max_turn_rad = 1e-3F;
  EXPECT_EQ(frames_until_full(options), 2) << "one frame says nothing about a way";
}

TEST(FragmentBuilder, ACourseBeginsAnewWithEachFragment) {
  FragmentOptions options;
  options.max_travel_m = 0.25F;
  FusedScene fused(AnalyticScene::room(), options);
  std::vector<std::size_t> frames;
  for (int i = 0; i < 40; ++i) {
    fused.add(shifted(0.03 * i, 0, 0));
    if (!fused.builder().full()) continue;
    const Fragment* closed = fused.builder().close(&fused.store());
    ASSERT_NE(closed, nullptr);
    frames.push_back(closed->frames.size());
    EXPECT_GE(closed->views.size(), 1U);
  }
  EXPECT_EQ(frames, (std::vector<std::size_t>{10, 10, 10, 10}));
}

TEST(FragmentOptions, ErrorsNameTheOption) {
  EXPECT_TRUE(validate(FragmentOptions()).ok());
  FragmentOptions options;
  options.frames_per_fragment = 0;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("fragment.frames_per_fragment"));
  options = {};
  options.views_per_fragment = 51;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("fragment.views_per_fragment"));
  options = {};
  options.max_drift_m = -1;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("fragment.max_drift_m"));
  options = {};
  options.thin_cell_m = 0;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("fragment.thin_cell_m"));
}

}  // namespace
}  // namespace loopsift
