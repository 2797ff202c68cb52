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
    EXPECT_EQ(scorer->dmp(poses).value, 0.0);
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
    EXPECT_NEAR(scorer->dmp(poses).value / expected, 1.0, 1e-4);
  }
}

TEST(MapScorer, TruthScoresBetterThanDriftAndDriftThanAFling) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<Se3> wrong = world.truth();
  wrong[6] = wrong[6] * shifted(0.2, 0, 0.2, 0.3);
  const double truth = scorer->dmp(world.truth()).value, drifted = scorer->dmp(world.odometry()).value;
  EXPECT_LT(truth, drifted);
  EXPECT_LT(drifted, scorer->dmp(wrong).value);
}

TEST(MapScorer, OnlyRelativePosesMatter) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<Se3> moved = world.odometry();
  for (Se3& pose : moved) pose = shifted(3, -1, 2, 0.8) * pose;
  const double here = scorer->dmp(world.odometry()).value;
  EXPECT_NEAR(scorer->dmp(moved).value / here, 1.0, 1e-2);
}

TEST(MapScorer, ViewValuesSumUpToTheScore) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  std::vector<float> values(static_cast<std::size_t>(scorer->view_count()), -1.0F);
  const MapScore score = scorer->dmp(world.odometry(), values);
  EXPECT_TRUE(score.complete);
  EXPECT_EQ(score.views_rendered, scorer->view_count());
  EXPECT_TRUE(std::all_of(values.begin(), values.end(), [](float v) { return v > 0; }));
  EXPECT_NEAR(std::accumulate(values.begin(), values.end(), 0.0) / score.value, 1.0, 1e-6);
}

TEST(MapScorer, GivingUpEarlyDecidesAsTheFullSum) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  for (const std::vector<Se3>& poses : {world.odometry(), world.truth()}) {
    const double full = scorer->dmp(poses).value;
    for (const double part : {0.0, 0.2, 0.5, 0.9, 0.999, 1.001, 1.1, 2.0}) {
      const MapScore score = scorer->dmp(poses, {}, part * full);
      EXPECT_EQ(score.complete, part > 1.0) << part;
      EXPECT_LE(score.value, full) << "a lower bound";
      EXPECT_GE(score.value, std::min(full, part * full));
      if (part < 0.6) {
        EXPECT_LT(score.views_rendered, scorer->view_count()) << part;
      }
    }
  }
}

// What may be left out without a word: every other fragment is drawn where it can be seen at all.
TEST(MapScorer, DrawsOtherFragmentsOneByOneAsAllAtOnce) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const std::vector<Se3>& poses = world.odometry();
  const ScoredView& view = scorer->view(3);
  const std::size_t pixels = static_cast<std::size_t>(padded_stride(view.camera.width) * view.camera.height);
  std::vector<float> together(pixels), one_by_one(pixels);
  scorer->render_others(view, poses, padded_image(together.data(), view.camera));
  for (std::size_t f = 0; f < poses.size(); ++f)
    scorer->render_others(view, poses, f, f + 1, padded_image(one_by_one.data(), view.camera));
  EXPECT_EQ(together, one_by_one);
  EXPECT_GT(std::count_if(together.begin(), together.end(), [](float inverse) { return inverse > 0; }), 100);
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
  EXPECT_GT(scorer->dmp(two).value, 0);
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
  EXPECT_EQ(too_small->dmp(pose).value, 0.0);

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
  EXPECT_EQ(first->dmp(world.odometry()).value, second->dmp(world.odometry()).value);
}

TEST(MapScorer, ComparePairIsNegativeWhenTheFirstExplainsBetter) {
  const TwoWalls walls;
  const Se3 good, bad = shifted(0, 0, -0.1);
  const auto compare = [&](const Se3& a, const Se3& b) {
    return walls.scorer->compare_pair(FragmentId{0}, FragmentId{1}, a, b);
  };
  EXPECT_NEAR(compare(good, bad), -0.1, 1e-5);
  EXPECT_NEAR(compare(bad, good), 0.1, 1e-5);
  EXPECT_EQ(compare(bad, bad), 0.0);
  EXPECT_EQ(compare(good, shifted(100, 0, 0)), 0.0) << "only pixels that both predict count";
}

TEST(MapScorer, ComparePairTakesTheFragmentsInEitherOrder) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Se3 good = world.loop(0, 0, 6).T_i_j, bad = good * shifted(0.05, 0, 0.1, 0.05);
  const FragmentId i{0}, j{6};
  EXPECT_LT(scorer->compare_pair(i, j, good, bad), 0);
  EXPECT_GT(scorer->compare_pair(i, j, bad, good), 0);
  EXPECT_NEAR(scorer->compare_pair(j, i, good.inverse(), bad.inverse()),
              scorer->compare_pair(i, j, good, bad), 1e-5);
}

TEST(MapScorer, ExplainsPairBestOnlyWhereEveryOtherIsWorse) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Se3 good = world.loop(0, 0, 6).T_i_j;
  const std::vector<Se3> worse = {good * shifted(0.05, 0, 0.1, 0.05), good * shifted(0, 0.1, -0.1, 0)};
  const FragmentId i{0}, j{6};
  const std::vector<Se3> with_the_good_one = {worse[1], good}, elsewhere = {shifted(100, 0, 0)};
  EXPECT_TRUE(scorer->explains_pair_best(i, j, good, worse));
  EXPECT_FALSE(scorer->explains_pair_best(i, j, worse[0], with_the_good_one));
  EXPECT_FALSE(scorer->explains_pair_best(i, j, good, elsewhere)) << "no pixel tells the two apart";
}

}  // namespace
}  // namespace loopsift
