// SPDX-License-Identifier: MIT
#include "tools/evaluation/loop_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace loopsift {
namespace {

using testing::HasSubstr;

Se3 shifted(const Se3& T, double x_m) { return T * Se3(Eigen::Matrix3d::Identity(), {x_m, 0, 0}); }

/// Three labelled loops and one neighbouring pair among six fragments; 1000 points in overlap each.
class LoopErrorTest : public testing::Test {
 protected:
  LoopErrorTest() {
    const int pairs[][2] = {{0, 1}, {0, 2}, {1, 4}, {2, 5}};
    for (const auto& pair : pairs) {
      Vector6d xi;
      xi << 0.1 * pair[0], 0.2 * pair[1], 0.5, 0.1, 0.2 * pair[0], -0.3;
      gt_.push_back({pair[0], pair[1], 6, Se3::exp(xi)});
      gt_info_.push_back({pair[0], pair[1], 6, 1000.0 * Matrix6d::Identity()});
    }
  }
  std::string error_of(const std::vector<LogRecord>& loops, int fragments = 0) const {
    const auto error = evaluate_loops(gt_, gt_info_, loops, {0.04, fragments});
    if (error.ok()) return "";
    EXPECT_EQ(error.error().code, ErrorCode::kUsage);
    return error.error().message;
  }
  std::vector<LogRecord> gt_;
  std::vector<InfoRecord> gt_info_;
};

TEST_F(LoopErrorTest, CountsTrueFalseAndUnlabelledLoops) {
  const std::vector<LogRecord> loops = {
      gt_[0],                              // neighbours: no loop
      {0, 2, 6, shifted(gt_[1].T, 0.19)},  // within 0.2 m: true
      {1, 4, 6, shifted(gt_[2].T, 0.21)},  // beyond: false
      {0, 5, 6, Se3()},                    // a pair without label: false
  };
  const auto error = evaluate_loops(gt_, gt_info_, loops, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->true_loops, 3);
  EXPECT_EQ(error->loops, 3);
  EXPECT_EQ(error->correct, 1);
  EXPECT_DOUBLE_EQ(error->recall, 1.0 / 3);
  EXPECT_DOUBLE_EQ(error->precision, 1.0 / 3);
}

TEST_F(LoopErrorTest, ALoopGivenTheOtherWayRoundIsTheSameLoop) {
  const auto error = evaluate_loops(gt_, gt_info_, {{5, 2, 6, gt_[3].T.inverse()}}, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->correct, 1);
}

TEST_F(LoopErrorTest, TheSameLoopTwiceDoesNotRaiseRecall) {
  const auto error = evaluate_loops(gt_, gt_info_, {gt_[1], gt_[1]}, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->correct, 2);
  EXPECT_DOUBLE_EQ(error->recall, 1.0 / 3);
  EXPECT_DOUBLE_EQ(error->precision, 1.0);
}

TEST_F(LoopErrorTest, NoLoopsIsZeroNotNan) {
  const auto error = evaluate_loops(gt_, gt_info_, {}, {});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->precision, 0);
  EXPECT_EQ(error->recall, 0);
}

TEST_F(LoopErrorTest, RotationCountsThroughItsInformation) {
  // 0.1 rad about z: ω = 2 q = 2 sin(0.05); with Λ_ωω / Λ₁₁ = 9 the error is 9 · 4 sin²(0.05) m².
  Matrix6d information = Matrix6d::Identity();
  information.bottomRightCorner<3, 3>() *= 9.0;
  const Se3 turn(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                 Eigen::Vector3d::Zero());
  const double s = std::sin(0.05);
  EXPECT_NEAR(loop_error_m2(gt_[1].T, 7.0 * information, gt_[1].T * turn), 36.0 * s * s, 1e-12);
}

TEST_F(LoopErrorTest, AnotherFragmentCountIsAnErrorUnlessAskedFor) {
  std::vector<LogRecord> loops = {gt_[1]};
  loops[0].n = 5;
  EXPECT_THAT(error_of(loops), HasSubstr("5 fragments but the ground truth is of 6"));
  const auto error = evaluate_loops(gt_, gt_info_, loops, {0.04, 5});
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error->true_loops, 2) << "the pair with fragment 5 is left out";
  EXPECT_EQ(error->correct, 1);
}

TEST_F(LoopErrorTest, AFragmentThatDoesNotExistIsNamed) {
  EXPECT_THAT(error_of({{1, 6, 6, Se3()}}), HasSubstr("loop 1 6 names a fragment"));
  EXPECT_THAT(error_of({{-1, 3, 6, Se3()}}), HasSubstr("loop -1 3 names a fragment"));
}

TEST_F(LoopErrorTest, GroundTruthFilesMustBelongTogether) {
  std::swap(gt_info_[1], gt_info_[2]);
  EXPECT_THAT(error_of({}), HasSubstr("do not belong together"));
  gt_info_.pop_back();
  EXPECT_THAT(error_of({}), HasSubstr("4 transforms and 3 information matrices"));
}

TEST_F(LoopErrorTest, GroundTruthWithoutLoopsIsAnError) {
  gt_.resize(1);
  gt_info_.resize(1);
  EXPECT_THAT(error_of({}), HasSubstr("labels no loop"));
}

}  // namespace
}  // namespace loopsift
