// SPDX-License-Identifier: MIT
// What the posterior adds to the paper's score: support, and the comparison of a pair.
#include <gtest/gtest.h>

#include "tests/unit/core/posterior/scored_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;
using test::scorer_of;
using test::shifted;
using test::TwoWalls;

TEST(MapScorer, TearingAMapApartPaysInThePlainScoreOnly) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const std::vector<Se3> drifted = world.odometry();
  scorer->set_reference(drifted);
  std::vector<Se3> torn = drifted;
  for (std::size_t f = 1; f < torn.size(); ++f)
    torn[f] = shifted(50.0 * static_cast<double>(f), 0, 0) * torn[f];
  EXPECT_LT(scorer->score(torn, ScoreKind::kPlain).value, scorer->score(drifted, ScoreKind::kPlain).value);
  EXPECT_GE(scorer->score(torn, ScoreKind::kPosterior).value * (1 + 1e-6),
            scorer->score(drifted, ScoreKind::kPosterior).value);
  scorer->clear_reference();
  EXPECT_LT(scorer->score(torn, ScoreKind::kPosterior).value,
            scorer->score(drifted, ScoreKind::kPosterior).value)
      << "without support the same tear pays";
}

TEST(MapScorer, APixelThatLostItsPredictionKeepsItsResidual) {
  const TwoWalls walls(2.01F);
  const std::vector<Se3> near = {Se3(), shifted(0, 0, -0.2)}, gone = {Se3(), shifted(100, 0, 0)};
  const auto score = [&](const std::vector<Se3>& poses) {
    return walls.scorer->score(poses, ScoreKind::kPosterior).value;
  };
  const double before = score(near);
  EXPECT_LT(score(gone), 0.1 * before);
  walls.scorer->set_reference(near);
  EXPECT_NEAR(score(gone), before, 1e-9);
  EXPECT_NEAR(score(near), before, 1e-9) << "the reference itself is worth the same with and without support";
  walls.scorer->set_reference(gone);
  EXPECT_NEAR(score(gone), before, 1e-9) << "support is sticky: a second step does not pay, either";
  const std::vector<Se3> better = {Se3(), shifted(0, 0, -0.1)};
  EXPECT_LT(score(better), before) << "a pixel that is predicted again counts as it is";
  walls.scorer->set_reference(better);
  EXPECT_NEAR(score(gone), score(better), 1e-9);
  walls.scorer->clear_reference();
  EXPECT_LT(score(gone), 0.1 * before);
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

}  // namespace
}  // namespace loopsift
