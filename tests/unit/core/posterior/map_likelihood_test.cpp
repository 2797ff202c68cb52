// SPDX-License-Identifier: MIT
#include "core/posterior/map_likelihood.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tests/unit/core/posterior/scored_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;
using test::scorer_of;
using test::shifted;
using test::small_options;
using test::TwoWalls;

constexpr Reference kBothReferences[] = {Reference::kOdometry, Reference::kBest};

class Likelihood {
 public:
  explicit Likelihood(const MapScorer& scorer) : likelihood_(std::cref(scorer)) {}
  MapLikelihood* operator->() const { return &*likelihood_; }
  [[nodiscard]] double of_map(Reference reference, const std::vector<Se3>& poses) const {
    double sum = 0;
    for (std::size_t v = 0; v < views(); ++v) sum += likelihood_->of_map(reference, v, poses);
    return sum;
  }
  [[nodiscard]] double of_reference(Reference reference) const {
    double sum = 0;
    for (std::size_t v = 0; v < views(); ++v) sum += likelihood_->of_reference(reference, v);
    return sum;
  }

 private:
  [[nodiscard]] std::size_t views() const {
    return static_cast<std::size_t>(likelihood_->scorer().view_count());
  }
  InArena<MapLikelihood> likelihood_;
};

std::vector<Se3> torn_apart(const std::vector<Se3>& poses) {
  std::vector<Se3> torn = poses;
  for (std::size_t f = 1; f < torn.size(); ++f)
    torn[f] = shifted(50.0 * static_cast<double>(f), 0, 0) * torn[f];
  return torn;
}

TEST(MapLikelihood, IsTwiceTheOwnResidualTimesTheMeanResidual) {
  const TwoWalls walls(2.03F);
  const Likelihood likelihood(*walls.scorer);
  const std::vector<Se3> poses = {Se3(), shifted(0, 0, -0.2)};
  const double expected = 2 * walls.scorer->own_residual() * 0.23;
  EXPECT_NEAR(likelihood->set_odometry_map(poses), expected, 1e-5);
  for (const Reference reference : kBothReferences) {
    EXPECT_NEAR(likelihood.of_reference(reference), expected, 1e-5);
    EXPECT_NEAR(likelihood.of_map(reference, poses), expected, 1e-5);
  }
}

TEST(MapLikelihood, TruthIsBetterThanDriftAndDriftThanAFling) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Likelihood likelihood(*scorer);
  std::vector<Se3> wrong = world.truth();
  wrong[6] = wrong[6] * shifted(0.2, 0, 0.2, 0.3);
  const double drifted = likelihood->set_odometry_map(world.odometry());
  for (const Reference reference : kBothReferences) {
    EXPECT_LT(likelihood.of_map(reference, world.truth()), drifted);
    EXPECT_LT(drifted, likelihood.of_map(reference, wrong));
  }
}

TEST(MapLikelihood, TearingAMapApartPaysInThePlainScoreOnly) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Likelihood likelihood(*scorer);
  const std::vector<Se3> torn = torn_apart(world.odometry());
  EXPECT_LT(scorer->dmp(torn).value, scorer->dmp(world.odometry()).value);
  const double drifted = likelihood->set_odometry_map(world.odometry());
  for (const Reference reference : kBothReferences)
    EXPECT_GE(likelihood.of_map(reference, torn) * (1 + 1e-6), drifted);
}

TEST(MapLikelihood, APixelThatLostItsPredictionKeepsItsResidual) {
  const TwoWalls walls(2.01F);
  const Likelihood likelihood(*walls.scorer);
  const std::vector<Se3> near = {Se3(), shifted(0, 0, -0.2)}, gone = {Se3(), shifted(100, 0, 0)};
  const std::vector<Se3> better = {Se3(), shifted(0, 0, -0.1)};
  const double before = likelihood->set_odometry_map(near);
  EXPECT_NEAR(likelihood.of_map(Reference::kOdometry, gone), before, 1e-9);
  likelihood->set_best_map(gone);
  EXPECT_NEAR(likelihood.of_reference(Reference::kBest), before, 1e-9);
  EXPECT_NEAR(likelihood.of_map(Reference::kBest, gone), before, 1e-9)
      << "a second step does not pay, either";
  const double improved = likelihood.of_map(Reference::kBest, better);
  EXPECT_LT(improved, 0.6 * before) << "a pixel that is predicted again counts as it is";
  likelihood->set_best_map(better);
  EXPECT_NEAR(likelihood.of_reference(Reference::kBest), improved, 1e-9);
  EXPECT_NEAR(likelihood.of_map(Reference::kBest, gone), improved, 1e-9);
  EXPECT_NEAR(likelihood.of_map(Reference::kOdometry, gone), before, 1e-9)
      << "what the best map supports is not the odometry's";
}

TEST(MapLikelihood, DrawsNewFragmentsOnTopAsIfAllWereThereFromTheStart) {
  const FragmentWorld world;
  const std::vector<Fragment>& fragments = world.fragments();
  InArena<MapScorer> growing(small_options());
  const Likelihood step_by_step(*growing), at_once(*growing);
  double score = 0;
  for (std::size_t f = 0; f < fragments.size(); ++f) {
    ASSERT_TRUE(growing->add(fragments[f]));
    score = step_by_step->set_odometry_map({world.odometry().data(), f + 1});
  }
  EXPECT_EQ(score, at_once->set_odometry_map(world.odometry()));
  EXPECT_GT(score, 0);
  const std::vector<Se3> torn = torn_apart(world.odometry());
  EXPECT_EQ(step_by_step.of_map(Reference::kOdometry, torn), at_once.of_map(Reference::kOdometry, torn));
  // Old fragments elsewhere: nothing that was drawn holds any more.
  EXPECT_EQ(step_by_step->set_odometry_map(world.truth()), at_once->set_odometry_map(world.truth()));
  EXPECT_EQ(step_by_step.of_map(Reference::kOdometry, torn), at_once.of_map(Reference::kOdometry, torn));
}

TEST(MapLikelihood, TheBestMapIsTheOdometrysUntilThereIsAnother) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Likelihood likelihood(*scorer);
  const double odometry = likelihood->set_odometry_map(world.odometry());
  EXPECT_EQ(likelihood.of_reference(Reference::kBest), likelihood.of_reference(Reference::kOdometry));
  likelihood->set_best_map(world.truth());
  EXPECT_LT(likelihood.of_reference(Reference::kBest), odometry);
  EXPECT_EQ(likelihood->poses(Reference::kBest)[6].matrix(), world.truth()[6].matrix());
  EXPECT_EQ(likelihood->poses(Reference::kOdometry)[6].matrix(), world.odometry()[6].matrix());
  likelihood->set_best_map(world.odometry());
  EXPECT_EQ(likelihood.of_reference(Reference::kBest), likelihood.of_reference(Reference::kOdometry));
  likelihood->set_best_map(world.truth());
  EXPECT_NEAR(likelihood->set_odometry_map(world.odometry()), odometry, 1e-12);
  EXPECT_EQ(likelihood.of_reference(Reference::kBest), likelihood.of_reference(Reference::kOdometry))
      << "a new odometry's map takes its place";
}

// A view's value must not depend on which others were asked for before it.
TEST(MapLikelihood, TheOrderOfQuestionsDoesNotMatter) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Likelihood forward(*scorer), backward(*scorer);
  for (const Likelihood* likelihood : {&forward, &backward}) {
    (void)(*likelihood)->set_odometry_map(world.odometry());
    (*likelihood)->set_best_map(world.truth());
  }
  const auto views = static_cast<std::size_t>(scorer->view_count());
  std::vector<double> up, down;
  for (std::size_t v = 0; v < views; ++v) {
    up.push_back(forward->of_map(Reference::kBest, v, world.odometry()));
    up.push_back(forward->of_reference(Reference::kBest, v));
  }
  for (std::size_t v = views; v-- > 0;) {
    down.push_back(backward->of_reference(Reference::kBest, v));
    down.push_back(backward->of_map(Reference::kBest, v, world.odometry()));
  }
  std::reverse(down.begin(), down.end());
  EXPECT_EQ(up, down);
}

TEST(MapLikelihood, ATrialThatBecomesTheBestMapIsWorthTheSameWithoutBeingDrawnAgain) {
  const FragmentWorld world;
  const InArena<MapScorer> scorer = scorer_of(world);
  const Likelihood tried(*scorer), fresh(*scorer);
  std::vector<Se3> other = world.truth();
  other[3] = other[3] * shifted(0.05, 0, 0);
  for (const Likelihood* likelihood : {&tried, &fresh})
    (void)(*likelihood)->set_odometry_map(world.odometry());
  (void)tried.of_map(Reference::kBest, world.truth());
  for (std::size_t v = 0; v < 3; ++v) (void)tried->of_map(Reference::kBest, v, other);  // a later trial
  for (std::size_t v = 0; v < 6; ++v) (void)tried->of_map(Reference::kOdometry, v, world.truth());
  tried->set_best_map(world.truth());
  fresh->set_best_map(world.truth());
  EXPECT_EQ(tried.of_reference(Reference::kBest), fresh.of_reference(Reference::kBest));
  EXPECT_EQ(tried.of_map(Reference::kBest, other), fresh.of_map(Reference::kBest, other));
}

TEST(MapLikelihood, CarvesWhatItMeasured) {
  const InArena<MapScorer> scorer(small_options());
  const InArena<MapLikelihood> likelihood(std::cref(*scorer));
  EXPECT_GT(likelihood.measured_bytes(), 0U);
  EXPECT_EQ(likelihood.measured_bytes(), likelihood.carved_bytes());
}

}  // namespace
}  // namespace loopsift
