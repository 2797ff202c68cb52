// SPDX-License-Identifier: MIT
#include "core/posterior/map_scorer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/unit/core/posterior/scored_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;
using test::scorer_of;
using test::shifted;
using test::small_options;
using test::TwoWalls;
using test::view_camera;
using test::WallFragment;

TEST(MapScorer, DmpOfAWallInFrontIsItsSquaredDistance) {
  const TwoWalls walls;
  EXPECT_NEAR(walls.plain(Se3()), 0.0, 1e-9);
  EXPECT_NEAR(walls.plain(shifted(0, 0, -0.1)), 0.01, 1e-6);
  EXPECT_NEAR(walls.plain(shifted(0, 0, -0.5)), 0.25, 1e-5);
  EXPECT_NEAR(walls.plain(shifted(0, 0, 0.5)), 0.0, 1e-9) << "a wall behind the nearer one is not seen";
  EXPECT_NEAR(walls.plain(shifted(100, 0, 0)), 0.0, 1e-9) << "nor one that is elsewhere";
}

TEST(MapScorer, DmpIsTheMeanOverTheViewsValidPixels) {
  const TwoWalls walls(2.0F, 0.4);  // the second wall covers a part of the image
  const std::vector<Se3> poses = {Se3(), shifted(0, 0, -0.5)};
  const auto valid = static_cast<double>(walls.scorer->valid_pixels(poses));
  EXPECT_EQ(valid, 80 * 60);
  // 0.8 m at 1.5 m depth are 38.7 pixels; the discs reach half a disc further on each side.
  EXPECT_NEAR(walls.plain(poses[1]) / 0.25 * 80, 38.7 + 2.4, 2.0);
}

TEST(MapScorer, OwnResidualIsTheScaleOfWhatViewsShowAboutTheirOwnFragment) {
  const double bin = 1e-3 / std::log(2.0);  // it is kept in millimetres
  EXPECT_NEAR(TwoWalls(2.03F).scorer->own_residual(), 0.03 / std::log(2.0), bin);
  EXPECT_NEAR(TwoWalls(1.96F).scorer->own_residual(), 0.04 / std::log(2.0), bin);
  EXPECT_EQ(InArena<MapScorer>(small_options())->own_residual(), 0.0);
}

TEST(MapScorer, SilhouettesDoNotCountInTheOwnResidual) {
  WallFragment wall(0, 2.5, 0.0F);
  std::vector<float> depth(80 * 60, 2.02F);
  std::fill_n(depth.begin(), 80 * 12, 3.5F);  // a fifth of the pixels looks past an edge
  const ScoreView view{0, view_camera(), {depth.data(), 80, 60}, Se3()};
  wall.fragment.views = Span<const ScoreView>(&view, 1);
  InArena<MapScorer> scorer(small_options());
  ASSERT_TRUE(scorer->add(wall.fragment));
  EXPECT_NEAR(scorer->own_residual(), 0.02 / std::log(2.0), 1e-3 / std::log(2.0));
}

TEST(MapScorer, PosteriorIsTwiceTheOwnResidualTimesTheMeanResidual) {
  const TwoWalls walls(2.03F);
  const std::vector<Se3> poses = {Se3(), shifted(0, 0, -0.2)};
  EXPECT_NEAR(walls.scorer->score(poses, ScoreKind::kPosterior).value,
              2 * walls.scorer->own_residual() * 0.23, 1e-5);
  EXPECT_NEAR(walls.scorer->score(poses, ScoreKind::kPlain).value, 0.23 * 0.23, 1e-5);
}

TEST(MapScorer, DepthOutOfRangeDoesNotCount) {
  for (const float measured : {0.0F, 0.29F, 6.1F}) {
    WallFragment first(0, 2.5, 1.0F);
    std::vector<float> depth(80 * 60, measured);
    const ScoreView view{0, view_camera(), {depth.data(), 80, 60}, Se3()};
    first.fragment.views = Span<const ScoreView>(&view, 1);
    InArena<MapScorer> scorer(small_options());
    ASSERT_TRUE(scorer->add(first.fragment));
    const std::vector<Se3> poses = {Se3()};
    EXPECT_EQ(scorer->valid_pixels(poses), 0) << measured;
    EXPECT_EQ(scorer->score(poses, ScoreKind::kPlain).value, 0.0);
  }
}

// The formula worked out from the fragments: discs thinned anew, all rendered into one image, summed in
// double.
double dmp_by_hand(const FragmentWorld& world, const std::vector<Se3>& poses, const PosteriorOptions& o) {
  double sum = 0;
  for (const Fragment& owner : world.fragments()) {
    for (const ScoreView& view : owner.views) {
      const int stride = padded_stride(view.camera.width);
      std::vector<float> predicted(static_cast<std::size_t>(stride * view.camera.height), 0.0F);
      const ImageView<float> image(predicted.data(), view.camera.width, view.camera.height, stride);
      const Se3 T_camera_map = (poses[owner.id.index()] * view.T_fragment_camera).inverse();
      for (const Fragment& fragment : world.fragments()) {
        std::vector<float> arrays[7];
        for (std::vector<float>& array : arrays) array.resize(fragment.surfels.size());
        std::vector<SurfelChunk> chunks(fragment.surfels.size() / kChunkSize + 1);
        ScoreSurfels discs{arrays[0], arrays[1], arrays[2], arrays[3],
                           arrays[4], arrays[5], arrays[6], chunks};
        ThinScratch scratch;
        EXPECT_EQ(thin(fragment.surfels, o.disc_spacing_m, o.disc_radius_m, &scratch, &discs), 0U);
        render_discs(discs, T_camera_map * poses[fragment.id.index()], view.camera, o.min_depth_m,
                     o.max_depth_m, image);
      }
      double squares = 0, pixels = 0;
      for (int y = 0; y < view.camera.height; ++y) {
        for (int x = 0; x < view.camera.width; ++x) {
          const double measured = static_cast<double>(view.depth_m(x, y));
          if (image(x, y) <= 0 || measured <= 0.3 || measured >= 6.0) continue;
          const double e = 1.0 / static_cast<double>(image(x, y)) - measured;
          squares += e * e, ++pixels;
        }
      }
      sum += squares / pixels;
    }
  }
  return sum;
}

TEST(MapScorer, DmpEqualsTheFormulaWorkedOutByHand) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<Se3> moved = world.truth();
  moved[1] = moved[1] * shifted(0.1, 0.0, -0.3, 0.1);
  for (const std::vector<Se3>& poses : {world.truth(), moved}) {
    const double expected = dmp_by_hand(world, poses, small_options());
    EXPECT_NEAR(scorer->score(poses, ScoreKind::kPlain).value / expected, 1.0, 1e-4);
  }
}

TEST(MapScorer, TruthScoresBetterThanDriftAndDriftThanAFling) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<Se3> wrong = world.truth();
  wrong[6] = wrong[6] * shifted(0.2, 0, 0.2, 0.3);
  for (const ScoreKind kind : {ScoreKind::kPlain, ScoreKind::kPosterior}) {
    const double truth = scorer->score(world.truth(), kind).value;
    const double drifted = scorer->score(world.odometry(), kind).value;
    EXPECT_LT(truth, drifted);
    EXPECT_LT(drifted, scorer->score(wrong, kind).value);
  }
}

TEST(MapScorer, OnlyRelativePosesMatter) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<Se3> moved = world.odometry();
  for (Se3& pose : moved) pose = shifted(3, -1, 2, 0.8) * pose;
  const double here = scorer->score(world.odometry(), ScoreKind::kPlain).value;
  EXPECT_NEAR(scorer->score(moved, ScoreKind::kPlain).value / here, 1.0, 1e-2);
}

TEST(MapScorer, ViewValuesSumUpToTheScore) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<float> values(static_cast<std::size_t>(scorer->view_count()), -1.0F);
  const MapScore score = scorer->score(world.odometry(), ScoreKind::kPosterior, {}, values);
  EXPECT_TRUE(score.complete);
  EXPECT_EQ(score.views_rendered, scorer->view_count());
  EXPECT_TRUE(std::all_of(values.begin(), values.end(), [](float v) { return v > 0; }));
  EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0) / score.value, 1.0, 1e-6);
}

TEST(MapScorer, OrderOfViewsDoesNotChangeTheValue) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const std::vector<std::uint16_t> first = {9, 3, 13, 0};
  ScoreLimits limits;
  limits.first_views = Span<const std::uint16_t>(first.data(), first.size());
  for (const ScoreKind kind : {ScoreKind::kPlain, ScoreKind::kPosterior}) {
    const double expected = scorer->score(world.odometry(), kind).value;
    const MapScore score = scorer->score(world.odometry(), kind, limits);
    EXPECT_EQ(score.views_rendered, scorer->view_count());
    EXPECT_NEAR(score.value / expected, 1.0, 1e-12);
  }
}

TEST(MapScorer, GivingUpEarlyDecidesAsTheFullSum) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  scorer->set_reference(world.truth());
  const std::vector<std::uint16_t> first = {12, 5, 1};
  bool saved = false;
  for (const ScoreKind kind : {ScoreKind::kPlain, ScoreKind::kPosterior}) {
    for (const std::vector<Se3>& poses : {world.odometry(), world.truth()}) {
      const double full = scorer->score(poses, kind).value;
      for (const double part : {0.0, 0.2, 0.5, 0.9, 0.999, 1.001, 1.1, 2.0}) {
        ScoreLimits limits;
        limits.give_up_above = part * full;
        if (part > 0.3) limits.first_views = Span<const std::uint16_t>(first.data(), first.size());
        const MapScore score = scorer->score(poses, kind, limits);
        EXPECT_EQ(score.complete, part > 1.0) << part;
        EXPECT_LE(score.value, full * (1 + 1e-6)) << "a lower bound";
        EXPECT_GE(score.value, std::min(full * (1 - 1e-12), limits.give_up_above));
        if (part > 1.0) {
          EXPECT_NEAR(score.value / full, 1.0, 1e-12);
        }
        saved = saved || score.views_rendered < scorer->view_count();
      }
    }
  }
  EXPECT_TRUE(saved);
}

// The lower bound of the views not yet looked at must hold for every map, or a good loop would be given up.
TEST(MapScorer, LeastThatViewsCanAddIsALowerBoundForAnyMap) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  for (int k = 0; k < 6; ++k) {
    std::vector<Se3> poses = world.truth();
    for (std::size_t f = 1; f < poses.size(); ++f)
      poses[f] = poses[f] * shifted(0.15 * k * std::sin(f), 0, 0.2 * k * std::cos(2.0 * f), 0.1 * k);
    ScoreLimits limits;
    limits.give_up_above = scorer->score(poses, ScoreKind::kPosterior).value * (1 + 1e-6);
    EXPECT_TRUE(scorer->score(poses, ScoreKind::kPosterior, limits).complete) << k;
  }
}

TEST(MapScorer, RefusesFragmentsPastItsCapacity) {
  const FragmentWorld world;
  PosteriorOptions options = small_options();
  options.max_fragments = 2;
  InArena<MapScorer> scorer(options);
  EXPECT_TRUE(scorer->add(world.fragments()[0]));
  EXPECT_TRUE(scorer->add(world.fragments()[1]));
  EXPECT_FALSE(scorer->add(world.fragments()[2]));
  EXPECT_EQ(scorer->fragment_count(), 2);
  EXPECT_EQ(scorer->view_count(), 4);
  const std::vector<Se3> two(world.truth().begin(), world.truth().begin() + 2);
  EXPECT_GT(scorer->score(two, ScoreKind::kPlain).value, 0);
}

TEST(MapScorer, LeavesOutViewsAndDiscsPastItsCapacity) {
  const FragmentWorld world;
  PosteriorOptions options = small_options();
  options.max_views_per_fragment = 1;
  InArena<MapScorer> one_view(options);
  EXPECT_TRUE(one_view->add(world.fragments()[0]));
  EXPECT_EQ(one_view->view_count(), 1);

  options = small_options();
  options.max_view_height = 59;
  InArena<MapScorer> too_small(options);
  EXPECT_TRUE(too_small->add(world.fragments()[0]));
  EXPECT_EQ(too_small->view_count(), 0);
  const std::vector<Se3> pose = {Se3()};
  EXPECT_EQ(too_small->score(pose, ScoreKind::kPosterior).value, 0.0);

  options = small_options();
  EXPECT_EQ(scorer_of(world, options)->discs_left_out(), 0U);
  options.max_discs_per_fragment = 500;
  EXPECT_GT(scorer_of(world, options)->discs_left_out(), 0U);
}

TEST(MapScorer, CarvesWhatItMeasured) {
  const InArena<MapScorer> scorer(small_options());
  EXPECT_GT(scorer.measured_bytes(), 0U);
  EXPECT_EQ(scorer.measured_bytes(), scorer.carved_bytes());
}

TEST(MapScorer, CentroidIsInTheMidstOfTheDiscs) {
  const TwoWalls walls;
  EXPECT_NEAR((walls.scorer->centroid(FragmentId{0}) - Eigen::Vector3d(0, 0, 2)).norm(), 0, 0.15);
}

TEST(MapScorer, GivesTheSameBitsTwice) {
  const FragmentWorld world;
  const InArena<MapScorer> first = scorer_of(world), second = scorer_of(world);
  for (const ScoreKind kind : {ScoreKind::kPlain, ScoreKind::kPosterior})
    EXPECT_EQ(first->score(world.odometry(), kind).value, second->score(world.odometry(), kind).value);
}

}  // namespace
}  // namespace loopsift
