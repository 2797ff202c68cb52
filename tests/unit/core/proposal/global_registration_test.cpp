// SPDX-License-Identifier: MIT
#include "core/proposal/global_registration.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

/// `good` matches under T with 1 cm noise, and `bad` ones between random points.
void make_matches(const Se3& T_target_source, int good, int bad, RegistrationCloud* target,
                  RegistrationCloud* source) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-1.5F, 1.5F);
  std::normal_distribution<float> noise(0.0F, 0.01F);
  const auto any = [&] { return Eigen::Vector3f(place(random), place(random), place(random)); };
  const Se3f T(T_target_source);
  for (int k = 0; k < good + bad; ++k) {
    const Eigen::Vector3f p = any(), n = any().normalized();
    source->points.push_back(p);
    source->normals.push_back(n);
    const bool is_good = k < good;
    target->points.push_back(
        is_good ? Eigen::Vector3f(T * p + Eigen::Vector3f(noise(random), noise(random), noise(random)))
                : any());
    target->normals.push_back(is_good ? Eigen::Vector3f(T.R * n) : any().normalized());
  }
}

TEST(GlobalRegistration, FindsTheMotionAmongNinetyPercentFalseMatches) {
  const Se3 truth = test::motion(3, -2, 1, 0.5, 2.2, -1.1);
  RegistrationCloud target, source;
  make_matches(truth, 40, 360, &target, &source);
  std::vector<MotionHypothesis> hypotheses;
  GlobalRegistration{GlobalRegistrationOptions()}.run(target, source, &hypotheses);
  ASSERT_FALSE(hypotheses.empty());
  EXPECT_GE(hypotheses[0].agreeing, 38);
  const Vector6d error = (truth.inverse() * hypotheses[0].T_target_source).log();
  EXPECT_LT(error.head<3>().norm(), 0.02);
  EXPECT_LT(error.tail<3>().norm(), 0.02);
}

TEST(GlobalRegistration, HandsBackBothOfTwoMotions) {
  const Se3 first = test::motion(1, 0, 0, 0, 0, 1), second = test::motion(-1, 0, 0, 0, 0, -1);
  RegistrationCloud target, source;
  make_matches(first, 60, 0, &target, &source);
  make_matches(second, 40, 100, &target, &source);
  std::vector<MotionHypothesis> hypotheses;
  GlobalRegistration{GlobalRegistrationOptions()}.run(target, source, &hypotheses);
  ASSERT_GE(hypotheses.size(), 2U);
  EXPECT_GE(hypotheses[0].agreeing, hypotheses[1].agreeing);
  EXPECT_LT((first.inverse() * hypotheses[0].T_target_source).log().norm(), 0.05);
  EXPECT_LT((second.inverse() * hypotheses[1].T_target_source).log().norm(), 0.05);
}

TEST(GlobalRegistration, FindsNothingInNoise) {
  RegistrationCloud target, source;
  make_matches(Se3(), 0, 300, &target, &source);
  std::vector<MotionHypothesis> hypotheses(1);
  GlobalRegistrationOptions options;
  options.min_agreeing = 15;
  GlobalRegistration(options).run(target, source, &hypotheses);
  EXPECT_TRUE(hypotheses.empty());
}

TEST(GlobalRegistration, FindsNothingInTooFewMatches) {
  GlobalRegistration registration{GlobalRegistrationOptions()};
  for (const int good : {0, 1, 2, 5}) {
    RegistrationCloud target, source;
    make_matches(Se3(), good, 0, &target, &source);
    std::vector<MotionHypothesis> hypotheses(1);
    registration.run(target, source, &hypotheses);
    EXPECT_TRUE(hypotheses.empty()) << good;
  }
}

TEST(FitRigid, RefusesLinesAndTooFewPoints) {
  const std::vector<Eigen::Vector3f> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 0, 0}};
  const std::vector<std::uint32_t> all = {0, 1, 2, 3}, two = {0, 1};
  Se3 T;
  EXPECT_FALSE(fit_rigid(line, line, all, &T));
  EXPECT_FALSE(fit_rigid(line, line, two, &T));
  const std::vector<Eigen::Vector3f> one_place(4, Eigen::Vector3f(1, 2, 3));
  EXPECT_FALSE(fit_rigid(one_place, one_place, all, &T));
}

TEST(FitRigid, IsExactAndNeverMirrors) {
  const std::vector<Eigen::Vector3f> source = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3F, 0.4F, 0}};
  const std::vector<std::uint32_t> all = {0, 1, 2, 3};
  const Se3 truth = test::motion(1, 2, 3, -0.7, 2.5, 0.4);
  std::vector<Eigen::Vector3f> target;
  for (const Eigen::Vector3f& p : source) target.push_back(Se3f(truth) * p);
  Se3 T;
  ASSERT_TRUE(fit_rigid(target, source, all, &T));
  EXPECT_LT((truth.inverse() * T).log().norm(), 1e-5);
  EXPECT_NEAR(T.rotation().determinant(), 1.0, 1e-9);
}

}  // namespace
}  // namespace loopsift
