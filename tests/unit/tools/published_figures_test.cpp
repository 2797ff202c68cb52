// SPDX-License-Identifier: MIT
// Figures known for public data: recall and precision of five proposers on two scenes (Choi et al. 2015), and
// the error of four estimated trajectories. Needs the data in the folder that LOOPSIFT_DATA names.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tools/evaluation/loop_error.hpp"
#include "tools/evaluation/trajectory_error.hpp"

namespace loopsift {
namespace {

class PublishedFiguresTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* data = std::getenv("LOOPSIFT_DATA");
    if (data == nullptr) GTEST_SKIP() << "LOOPSIFT_DATA is not set";
    data_ = data;
  }
  std::string data_;
};

TEST_F(PublishedFiguresTest, RecallAndPrecisionOfFiveProposers) {
  struct Row {
    const char *scene, *proposer;
    double recall_percent, precision_percent;
    int true_loops;
  };
  const Row rows[] = {{"livingroom1", "opencv", 3.3, 1.2, 271},
                      {"livingroom1", "4pcs", 17.3, 9.9, 271},
                      {"livingroom1", "super4pcs", 15.9, 10.3, 271},
                      {"livingroom1", "pcl", 36.5, 22.2, 271},
                      {"livingroom1", "pcl_modified", 61.3, 27.2, 271},
                      {"office1", "opencv", 5.6, 2.1, 180},
                      {"office1", "4pcs", 17.8, 7.3, 180},
                      {"office1", "super4pcs", 12.8, 6.6, 180},
                      {"office1", "pcl", 46.7, 15.3, 180},
                      {"office1", "pcl_modified", 64.4, 19.2, 180}};
  for (const Row& row : rows) {
    SCOPED_TRACE(std::string(row.scene) + " " + row.proposer);
    const std::string folder = data_ + "/redwood_loops/" + row.scene + "/";
    const auto gt = read_log(folder + "gt.log");
    const auto gt_info = read_info(folder + "gt.info");
    const auto loops = read_log(folder + row.proposer + ".log");
    ASSERT_TRUE(gt.ok() && gt_info.ok() && loops.ok());
    const auto error = evaluate_loops(*gt, *gt_info, *loops, {});
    ASSERT_TRUE(error.ok()) << error.error().message;
    EXPECT_EQ(error->true_loops, row.true_loops);
    EXPECT_NEAR(100 * error->recall, row.recall_percent, 0.06);
    EXPECT_NEAR(100 * error->precision, row.precision_percent, 0.06);
  }
}

TEST_F(PublishedFiguresTest, ErrorOfFourTrajectories) {
  const auto gt = read_trajectory(data_ + "/icl_livingroom/m1.log");
  ASSERT_TRUE(gt.ok()) << gt.error().message;
  const struct {
    const char* name;
    double ate_rmse_m;
  } rows[] = {{"m2", 0.0636}, {"m3", 0.1294}, {"m4", 0.3967}, {"m5", 1.8238}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const auto est = read_trajectory(data_ + "/icl_livingroom/" + row.name + ".log");
    ASSERT_TRUE(est.ok()) << est.error().message;
    const auto pairs = associate(*gt, *est, {});
    ASSERT_TRUE(pairs.ok()) << pairs.error().message;
    EXPECT_EQ(pairs->size(), 2350U);
    EXPECT_NEAR(trajectory_error(*pairs).ate_rmse_m, row.ate_rmse_m, 1e-4);
  }
}

}  // namespace
}  // namespace loopsift
