// SPDX-License-Identifier: MIT
#include "core/fragment/front_end.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/unit/core/fragment/fused_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::SceneCamera;
using test::shifted;
using test::small_camera;

// A front end on a noisy room.
class Walk {
 public:
  Walk() : camera_(small_camera(), 21) {
    options_.frame = test::halved();
    options_.fragment.frames_per_fragment = 15;
    Arena measuring;
    const FragmentStore unused_store(test::small_store(), measuring);
    const FrontEnd unused(small_camera(), SceneCamera::kUnitM, options_, nullptr, measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    store_ = std::make_unique<FragmentStore>(test::small_store(), *arena_);
    front_end_ =
        std::make_unique<FrontEnd>(small_camera(), SceneCamera::kUnitM, options_, store_.get(), *arena_);
  }
  RawFrame capture(const Se3& T) { return camera_.capture(AnalyticScene::room(), T, 0.0012, 0.0019); }
  RawFrame capture_color(const Se3& T) {
    return camera_.capture_color(AnalyticScene::room(), T, 0.0012, 0.0019);
  }
  FrontEndResult see(const Se3& T) { return front_end_->process(capture(T)); }
  FrontEndResult see_nothing() { return front_end_->process(camera_.black()); }
  FrontEnd& front_end() { return *front_end_; }
  FragmentStore& store() { return *store_; }

  // A walk along an arc, 0.5 m/s and 30 °/s.
  static Se3 pose(int i) { return shifted(0.017 * i, 0.01 * std::sin(0.3 * i), 0.005 * i, 0.017 * i); }

 private:
  SceneCamera camera_;
  FrontEndOptions options_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<FragmentStore> store_;
  std::unique_ptr<FrontEnd> front_end_;
};

TEST(FrontEnd, TracksAWalkAndClosesFragments) {
  Walk run;
  std::vector<const Fragment*> closed;
  for (int i = 0; i < 45; ++i) {
    const FrontEndResult result = run.see(Walk::pose(i));
    ASSERT_EQ(result.tracking.status, i == 0 ? TrackingStatus::kFirst : TrackingStatus::kTracked) << i;
    const Se3 truth = Walk::pose(0).inverse() * Walk::pose(i);
    const Vector6d error = (truth.inverse() * result.tracking.T_odom_camera).log();
    ASSERT_LT(error.head<3>().norm(), 0.01) << i;
    ASSERT_LT(error.tail<3>().norm(), 0.005) << i;
    if (result.closed != nullptr) closed.push_back(result.closed);
  }
  ASSERT_EQ(closed.size(), 3U);
  EXPECT_FALSE(closed[0]->joined_to_previous);
  EXPECT_TRUE(closed[1]->joined_to_previous);
  EXPECT_TRUE(closed[2]->joined_to_previous);
  EXPECT_EQ(run.front_end().finish(), nullptr) << "nothing is left open";
}

// At five frames a second, to and fro: no constant velocity predicts it.
TEST(FrontEnd, HoldsTurnsOfTwelveDegreesAFrame) {
  for (const bool color : {true, false}) {
    Walk run;
    for (int i = 0; i < 12; ++i) {
      const Se3 T = shifted(0.01 * i, 0, 0, i % 4 == 1 || i % 4 == 2 ? 0.21 : 0.0);
      RawFrame raw = color ? run.capture_color(T) : run.capture(T);
      raw.timestamp_ns = i * std::int64_t{200000000};
      const FrontEndResult result = run.front_end().process(raw);
      ASSERT_EQ(result.tracking.status, i == 0 ? TrackingStatus::kFirst : TrackingStatus::kTracked) << i;
      const Vector6d error = (T.inverse() * result.tracking.T_odom_camera).log();
      EXPECT_LT(error.head<3>().norm(), 0.015) << i << " colour " << color;
      EXPECT_LT(error.tail<3>().norm(), 0.01) << i << " colour " << color;
    }
  }
}

TEST(FrontEnd, ACoveredLensIsLostAndThenStartsAPieceOfItsOwn) {
  Walk run;
  for (int i = 0; i < 8; ++i) (void)run.see(Walk::pose(i));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(run.see_nothing().tracking.status, TrackingStatus::kLost);
  const FrontEndResult again = run.see(Walk::pose(60));
  EXPECT_EQ(again.tracking.status, TrackingStatus::kFirst);
  ASSERT_NE(again.closed, nullptr) << "what was mapped before the loss is kept";
  EXPECT_EQ(again.closed->frames.size(), 8U);
  for (int i = 61; i < 70; ++i)
    EXPECT_EQ(run.see(Walk::pose(i)).tracking.status, TrackingStatus::kTracked) << i;
  const Fragment* last = run.front_end().finish();
  ASSERT_NE(last, nullptr);
  EXPECT_FALSE(last->joined_to_previous);
}

TEST(FrontEnd, AShortLossGoesOnInTheSameFragment) {
  Walk run;
  for (int i = 0; i < 6; ++i) (void)run.see(Walk::pose(i));
  for (int i = 0; i < 2; ++i) EXPECT_EQ(run.see_nothing().tracking.status, TrackingStatus::kLost);
  for (int i = 8; i < 12; ++i)
    EXPECT_EQ(run.see(Walk::pose(i)).tracking.status, TrackingStatus::kTracked) << i;
  const Fragment* only = run.front_end().finish();
  ASSERT_NE(only, nullptr);
  EXPECT_EQ(only->frames.size(), 10U);
  EXPECT_EQ(run.store().fragments().size(), 1U);
}

TEST(FrontEnd, TakesPosesFromElsewhere) {
  Walk run;
  for (int i = 0; i < 15; ++i) {
    TrackingResult given;
    given.status = i == 0 ? TrackingStatus::kFirst : TrackingStatus::kTracked;
    given.T_odom_camera = Walk::pose(i);
    const FrontEndResult result = run.front_end().process(run.capture(Walk::pose(i)), given);
    EXPECT_EQ(result.closed != nullptr, i == 14);
  }
  const Fragment& fragment = run.store().fragments()[0];
  EXPECT_LT((fragment.frames[14].T_fragment_camera.inverse() * Walk::pose(0).inverse() * Walk::pose(14))
                .log()
                .norm(),
            1e-9);
  EXPECT_GT(fragment.surfels.size(), 1000U);
}

TEST(FrontEnd, TheSameInputGivesTheSameBits) {
  Walk one, two;
  for (int i = 0; i < 20; ++i) {
    const Se3 a = one.see(Walk::pose(i)).tracking.T_odom_camera,
              b = two.see(Walk::pose(i)).tracking.T_odom_camera;
    ASSERT_EQ(a.matrix(), b.matrix());
  }
  const SurfelSpan a = one.store().fragments()[0].surfels, b = two.store().fragments()[0].surfels;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a.x[i], b.x[i]);
}

// The model view of one closed wall must lie on the wall, and an older wall stands before a newer one close
// to it.
TEST(ModelRenderer, OlderSurfacesStandAndNearerOnesHide) {
  test::FusedScene old_wall(AnalyticScene::wall()), new_wall(AnalyticScene::wall());
  new_wall.scene.planes[0].offset = -1.98;
  for (int i = 0; i < 3; ++i) {
    old_wall.add(Se3());
    new_wall.add(Se3());
  }
  std::vector<Fragment> fragments;
  fragments.push_back(*old_wall.builder().close(&old_wall.store()));
  fragments.push_back(*new_wall.builder().close(&new_wall.store()));
  const PinholeCamera working = small_camera().block_averaged(2);
  Arena measuring;
  const ModelRenderer unused({}, working, measuring);
  Arena arena(measuring.used_bytes());
  ModelRenderer renderer({}, working, arena);
  const ModelView& same = renderer.render({fragments.data(), 2}, {}, Se3(), Se3());
  const int u = same.camera.width / 2, v = same.camera.height / 2;
  EXPECT_NEAR(same.z(u, v), 2.0F, 0.003F) << "2 cm apart: the older stands";
  EXPECT_NEAR(same.nz(u, v), -1.0F, 1e-3F);
  EXPECT_EQ(same.disparity_unknown, 1.0F) << "a fragment of which nothing is known";
  fragments[0].disparity_unknown = 0.2F;
  EXPECT_EQ(renderer.render({fragments.data(), 2}, {}, Se3(), Se3()).disparity_unknown, 0.2F)
      << "only what is in sight counts";
  fragments[1].T_odom_fragment = shifted(0, 0, -0.5);
  EXPECT_NEAR(renderer.render({fragments.data(), 2}, {}, Se3(), Se3()).z(u, v), 1.48F, 0.003F)
      << "half a metre in front";
  int empty = 0;
  for (int y = 2; y < same.camera.height - 2; ++y)
    for (int x = 2; x < same.camera.width - 2; ++x) empty += same.z(x, y) == 0.0F ? 1 : 0;
  EXPECT_EQ(empty, 0) << "a closed wall has no holes";
}

}  // namespace
}  // namespace loopsift
