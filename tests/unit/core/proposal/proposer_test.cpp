// SPDX-License-Identifier: MIT
#include "core/proposal/proposer.hpp"

#include <gmock/gmock.h>

#include <deque>
#include <limits>
#include <random>

#include "tests/support/in_arena.hpp"
#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

using test::SurfelCloud;

/// Fragments of the furnished corner, and a proposer over them.
class ProposerTest : public ::testing::Test {
 protected:
  /// A fragment whose first camera is at T_map_fragment.
  void add(SurfelCloud surfels, const Se3& T_map_fragment) {
    clouds_.push_back(std::move(surfels));
    Fragment fragment;
    fragment.id.value = static_cast<std::int32_t>(fragments_.size());
    fragment.surfels = clouds_.back().span();
    fragments_.push_back(fragment);
    truth_.push_back(T_map_fragment);
  }
  void add_corner(const Se3& T, double from_x, double to_x) {
    add(test::furnished_corner(T, [=](const Eigen::Vector3d& p) { return p.x() >= from_x && p.x() <= to_x; }),
        T);
  }
  std::vector<Loop> propose_all(const ProposalOptions& options, Span<const Se3> estimate) {
    Arena measuring;
    { const Proposer sized(options, measuring); }
    Arena arena(measuring.used_bytes());
    Proposer proposer(options, arena);
    std::vector<Loop> loops;
    for (const Fragment& fragment : fragments_) {
      proposer.add_fragment(fragment);
      proposer.propose(fragment.id, estimate, {}, &loops);
    }
    counts_ = proposer.counts();
    return loops;
  }
  [[nodiscard]] Se3 truth(const Loop& loop) const {
    return truth_[loop.i.index()].inverse() * truth_[loop.j.index()];
  }

  std::deque<SurfelCloud> clouds_;
  std::deque<Fragment> fragments_;
  std::vector<Se3> truth_;
  ProposalCounts counts_;
};

const Se3 kFar = test::motion(4, -3, 1, 0.3, 0.4, 2.6);

TEST_F(ProposerTest, RegistersPartlyOverlappingFragmentsAcrossALargeMotion) {
  add_corner(test::motion(0.2, 0.1, 0, 0, 0, 0.1), 0, 2.2);
  add(test::flat_floor(), Se3());
  add_corner(kFar, 0.7, 3);
  const std::vector<Loop> loops = propose_all({}, {});
  ASSERT_EQ(loops.size(), 1U);
  const Loop& loop = loops[0];
  EXPECT_EQ(loop.i.value, 0);
  EXPECT_EQ(loop.j.value, 2);
  EXPECT_EQ(loop.id.value, 0);
  const Vector6d error = (loop.T_i_j.inverse() * truth(loop)).log();
  EXPECT_LT(error.head<3>().norm(), 0.01);
  EXPECT_LT(error.tail<3>().norm(), 0.01);
  EXPECT_GT(loop.overlap, 0.4F);
  EXPECT_LT(loop.overlap, 0.95F);
  EXPECT_LT(loop.residual_m, 0.01F);
}

TEST_F(ProposerTest, InformationIsThatOfARightPerturbationOfTheLoop) {
  add_corner(Se3(), 0, 3);
  add(test::flat_floor(), Se3());
  add_corner(kFar, 0, 3);
  const std::vector<Loop> loops = propose_all({}, {});
  ASSERT_EQ(loops.size(), 1U);
  // The cost of registering i in j, as a function of a right perturbation of T_i_j.
  RegistrationCloud source, target;
  VoxelThinner thinner{RegistrationCloudOptions()};
  thinner.thin(fragments_[0].surfels, &source);
  thinner.thin(fragments_[2].surfels, &target);
  NearestField field;
  field.build(target.points, 0.2F, 0.05F, 1 << 20);
  const IcpOptions options;
  const auto cost = [&](const Vector6d& xi) {
    const Se3 T_i_j = loops[0].T_i_j * Se3::exp(xi);
    return point_to_plane_system(options, {&target, &field}, source, T_i_j.inverse(), 0.06F, 1,
                                 Loss::kSquared)
        .cost;
  };
  constexpr double kStep = 4e-3;
  for (int a = 0; a < 6; ++a) {
    const Vector6d u = kStep * Vector6d::Unit(a);
    const double numeric = (cost(u) - 2 * cost(Vector6d::Zero()) + cost(-u)) / (kStep * kStep);
    // Partners change with the perturbation, which a quadratic model leaves out.
    EXPECT_NEAR(loops[0].information(a, a) * static_cast<double>(options.correlated_pairs), numeric,
                0.15 * numeric)
        << a;
  }
}

TEST_F(ProposerTest, GivesTheSameLoopsAgain) {
  add_corner(Se3(), 0, 2.2);
  add_corner(test::motion(1, 0, 0, 0, 0, 1), 0, 3);
  add_corner(kFar, 0.7, 3);
  add_corner(test::motion(-1, 2, 0, 1, 0, 0), 0.3, 2.6);
  const std::vector<Loop> first = propose_all({}, truth_), again = propose_all({}, truth_);
  ASSERT_GE(first.size(), 2U);
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].T_i_j.matrix(), again[k].T_i_j.matrix());
    EXPECT_EQ(first[k].information, again[k].information);
    EXPECT_EQ(first[k].id.value, static_cast<int>(k));
    EXPECT_LT(first[k].i.value + 1, first[k].j.value);
  }
}

TEST_F(ProposerTest, KeepsBothWhenTheEstimateLeadsElsewhere) {
  // A long box row: shifted by one box it fits nearly as well, and the estimate sits on the shifted place.
  SurfelCloud row;
  test::SurfaceSampler sample(
      Se3(), [](const Eigen::Vector3d&) { return true; }, &row);
  sample.patch({0, 0, 0}, {4.2, 0, 0}, {0, 1.5, 0});
  for (int k = 0; k < 6; ++k) sample.box({0.2 + 0.65 * k, 0.5, 0}, {0.3, 0.4, 0.5}, 0);
  sample.sphere({0.35, 1.2, 0.2}, 0.2);
  add(row, Se3());
  add(test::flat_floor(), Se3());
  add(row, Se3());
  std::vector<Se3> estimate(3);
  estimate[2] = test::motion(0.65, 0.02, 0, 0, 0, 0);
  const std::vector<Loop> loops = propose_all({}, estimate);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_LT(loops[0].T_i_j.log().norm(), 0.02);
  EXPECT_NEAR(loops[1].T_i_j.translation().x(), 0.65, 0.03);
  EXPECT_GT(loops[0].overlap, loops[1].overlap);
}

TEST_F(ProposerTest, APairIsTriedAgainOnceTheEstimateHasChanged) {
  add_corner(Se3(), 0, 3);
  add(test::flat_floor(), Se3());
  add_corner(kFar, 0, 3);
  ProposalOptions options;
  options.global.min_agreeing = 65534;  // features alone lead nowhere
  const test::InArena<Proposer> proposer(options);
  const std::vector<Se3> drifted = {Se3(), test::motion(9, 0, 0, 0, 0, 0),
                                    kFar * test::motion(5, 0, 0, 0, 0, 0)};
  std::vector<Loop> loops;
  for (const Fragment& fragment : fragments_) {
    proposer->add_fragment(fragment);
    proposer->propose(fragment.id, drifted, {}, &loops);
  }
  proposer->propose_again(drifted, &loops);
  EXPECT_TRUE(loops.empty());
  EXPECT_EQ(proposer->counts().pairs_repeated, 0) << "the estimate is the one that was tried";
  std::vector<Se3> corrected = truth_;
  corrected[1] = drifted[1];
  corrected[2] = corrected[2] * test::motion(0.03, 0.01, -0.02, 0, 0.01, 0);
  proposer->propose_again(corrected, &loops);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].i.value, 0);
  EXPECT_EQ(loops[0].j.value, 2);
  EXPECT_LT((loops[0].T_i_j.inverse() * truth(loops[0])).log().norm(), 0.02);
  corrected[2] = truth_[2];
  proposer->propose_again(corrected, &loops);
  EXPECT_EQ(loops.size(), 1U);
  EXPECT_EQ(proposer->counts().pairs_repeated, 1) << "a few centimetres are no other estimate";
}

TEST_F(ProposerTest, RepeatsNoMoreThanAllowed) {
  for (int k = 0; k < 6; ++k) add_corner(test::motion(0.05 * k, 0, 0, 0, 0, 0), 0, 3);
  ProposalOptions options;
  options.max_repeats_per_fragment = 3;
  options.max_registrations_per_fragment = 1;
  const test::InArena<Proposer> proposer(options);
  std::vector<Loop> loops;
  for (const Fragment& fragment : fragments_) {
    proposer->add_fragment(fragment);
    proposer->propose(fragment.id, truth_, {}, &loops);
  }
  const auto skipped = proposer->counts().pairs_skipped;
  EXPECT_EQ(skipped, 6);
  for (const std::int64_t expected : {3, 6, 6}) {  // what was never tried is tried, a few at a time
    proposer->propose_again(truth_, &loops);
    EXPECT_EQ(proposer->counts().pairs_repeated, expected);
  }
}

TEST_F(ProposerTest, TheUncertainEstimateIsTriedWhereItMayOverlap) {
  add_corner(Se3(), 0, 3);
  add(test::flat_floor(), Se3());
  add_corner(Se3(), 0, 3);
  ProposalOptions options;
  options.global.min_agreeing = 65534;
  options.min_expected_overlap = 0.1F;
  // Along z, where the estimate is, nothing overlaps; a standard deviation back, all does.
  const std::vector<Se3> drifted = {Se3(), test::motion(9, 0, 0, 0, 0, 0), test::motion(0, 0, 3, 0, 0, 0)};
  for (const float drift_m : {0.0F, 3.0F}) {
    const test::InArena<Proposer> proposer(options);
    std::vector<Loop> loops;
    const std::vector<float> drift = {drift_m, drift_m, 0.0F};
    for (const Fragment& fragment : fragments_) proposer->add_fragment(fragment);
    const auto before = proposer->counts().pairs_tried;
    proposer->propose(FragmentId{2}, drifted, drift, &loops);
    EXPECT_EQ(proposer->counts().pairs_tried, before + 1);
    EXPECT_EQ(proposer->counts().estimates_tried, drift_m > 0 ? 1 : 0);
  }
}

TEST_F(ProposerTest, AgreeingStartsAreOneProposal) {
  add_corner(Se3(), 0, 3);
  add(test::flat_floor(), Se3());
  add_corner(kFar, 0, 3);
  const std::vector<Loop> loops = propose_all({}, truth_);
  for (const Loop& loop : loops)
    EXPECT_LT((loop.T_i_j.inverse() * truth(loop)).log().norm(), 0.02) << loop.overlap;
  EXPECT_EQ(loops.size(), 1U);
}

TEST_F(ProposerTest, ProposesNothingForUnlikePlaces) {
  add_corner(Se3(), 0, 3);
  add(test::flat_floor(), Se3());
  SurfelCloud pipes;
  test::SurfaceSampler sample(
      Se3(), [](const Eigen::Vector3d&) { return true; }, &pipes);
  for (int k = 0; k < 12; ++k) sample.sphere({0.5 * (k % 4), 0.6 * (k / 4), 0.3 * (k % 3)}, 0.12);
  add(pipes, Se3());
  EXPECT_TRUE(propose_all({}, {}).empty());
}

TEST_F(ProposerTest, SurvivesDegenerateFragments) {
  SurfelCloud nothing, few, bad;
  for (int k = 0; k < 10; ++k) few.add({0.1 * k, 0, 1}, {0, 0, -1});
  for (int k = 0; k < 500; ++k)
    bad.add(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), {0, 0, 1});
  add(test::flat_floor(), Se3());
  add(nothing, Se3());
  add(few, Se3());
  add(test::flat_floor(), Se3());
  add(bad, Se3());
  add(nothing, Se3());
  add(test::flat_floor(), test::motion(0.1, 0, 0, 0, 0, 0));
  EXPECT_TRUE(propose_all({}, {}).empty());
  for (const Loop& loop : propose_all({}, truth_))
    EXPECT_TRUE(loop.T_i_j.is_valid()) << loop.i.value << '-' << loop.j.value;
  EXPECT_EQ(counts_.fragments, 7);
}

// One floor says nothing about sliding on it: there the estimate stays, and the loop claims nothing.
TEST_F(ProposerTest, WhatASharedSurfaceDoesNotDetermineIsTheEstimates) {
  for (int k = 0; k < 3; ++k) add(test::flat_floor(), Se3());
  EXPECT_TRUE(propose_all({}, {}).empty()) << "matches alone are not believed";
  std::vector<Se3> estimate = truth_;
  estimate[2] = test::motion(0.06, 0.03, 0.04, 0, 0, 0);
  const std::vector<Loop> loops = propose_all({}, estimate);
  ASSERT_EQ(loops.size(), 1U);
  const Eigen::Vector3d t = loops[0].T_i_j.translation(), across = Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(t.dot(across), 0, 0.01) << "across the floor it is registered";
  EXPECT_NEAR((t - across * t.dot(across)).norm(), std::hypot(0.06, 0.03), 0.02) << "on it it stays";
  const Eigen::Matrix3d information = loops[0].information.topLeftCorner<3, 3>();
  EXPECT_LT(information(0, 0), 0.01 * information(2, 2));
}

TEST_F(ProposerTest, TriesNoMorePairsThanAllowedAndTheLikelyOnesFirst) {
  for (int k = 0; k < 3; ++k) add(test::flat_floor(), Se3());
  add_corner(Se3(), 0, 3);
  add(test::flat_floor(), Se3());
  add_corner(test::motion(0.05, 0, 0, 0, 0, 0.1), 0, 3);
  ProposalOptions options;
  options.max_registrations_per_fragment = 1;
  // The one pair that may be tried is the one that looks alike.
  EXPECT_EQ(propose_all(options, {}).size(), 1U);
  EXPECT_EQ(counts_.pairs_tried, 4);
  EXPECT_EQ(counts_.pairs_skipped, 6);
}

TEST_F(ProposerTest, RefusesFragmentsBeyondItsCapacityOrOutOfOrder) {
  for (int k = 0; k < 4; ++k) add_corner(test::motion(k, 0, 0, 0, 0, 0), 0, 3);
  ProposalOptions options;
  options.max_fragments = 3;
  const std::vector<Loop> loops = propose_all(options, {});
  EXPECT_EQ(counts_.refused_fragments, 1);
  EXPECT_EQ(counts_.fragments, 3);
  EXPECT_THAT(loops, ::testing::Each(::testing::Field(&Loop::j, FragmentId{2})));
  Arena measuring;
  { const Proposer sized(options, measuring); }
  Arena arena(measuring.used_bytes());
  Proposer proposer(options, arena);
  EXPECT_TRUE(proposer.add_fragment(fragments_[1]));
  EXPECT_FALSE(proposer.add_fragment(fragments_[1]));
  EXPECT_FALSE(proposer.add_fragment(fragments_[0]));
}

TEST(ProposalOptions, AreCheckedByName) {
  EXPECT_TRUE(validate(ProposalOptions()));
  const auto message = [](auto change) {
    ProposalOptions options;
    change(options);
    const Status status = validate(options);
    return status ? std::string() : status.error().message;
  };
  using ::testing::HasSubstr;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message([](auto& o) { o.cloud.voxel_m = 0; }), HasSubstr("voxel_m"));
  EXPECT_THAT(message([](auto& o) { o.cloud.max_points = 70000; }), HasSubstr("max_points"));
  EXPECT_THAT(message([](auto& o) { o.features.radius_m = 0.01F; }), HasSubstr("feature_radius_m"));
  EXPECT_THAT(message([](auto& o) { o.features.max_keypoints = 0; }), HasSubstr("max_keypoints"));
  EXPECT_THAT(message([](auto& o) { o.global.companions = 1; }), HasSubstr("companions"));
  EXPECT_THAT(message([](auto& o) { o.icp.stages[1].stride = 0; }), HasSubstr("stages"));
  EXPECT_THAT(message([](auto& o) { o.icp.sigma_floor_m = kNan; }), HasSubstr("sigma_floor_m"));
  EXPECT_THAT(message([](auto& o) { o.min_overlap = 1.5F; }), HasSubstr("min_overlap"));
  EXPECT_THAT(message([](auto& o) { o.max_fragments = 0; }), HasSubstr("max_fragments"));
  EXPECT_THAT(message([](auto& o) { o.max_registrations_per_fragment = 0; }),
              HasSubstr("max_registrations_per_fragment"));
  EXPECT_THAT(message([](auto& o) { o.max_repeats_per_fragment = -1; }),
              HasSubstr("max_repeats_per_fragment"));
}

}  // namespace
}  // namespace loopsift
