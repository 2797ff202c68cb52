// SPDX-License-Identifier: MIT
#include "tools/evaluation/loop_ranking.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using testing::HasSubstr;

constexpr const char* kHeader =
    "id,fragment_i,fragment_j,single_dmp,rank,tested_dmp,best_dmp_before,decision,reason,frame_decided\n";

/// Three labelled pairs; proposals 0 and 2 are true, 1 is off by a metre, 3 has no label, 4 is odometry.
class LoopRanking : public testing::Test {
 protected:
  LoopRanking() {
    for (const int j : {2, 3, 4}) {
      gt_.push_back({0, j, 6, Se3()});
      gt_info_.push_back({0, j, 6, Matrix6d::Identity()});
    }
    const Se3 off(Eigen::Matrix3d::Identity(), {1, 0, 0});
    proposals_ = {{0, 2, 6, Se3()}, {0, 3, 6, off}, {3, 0, 6, Se3()}, {1, 5, 6, Se3()}, {4, 5, 6, Se3()}};
  }
  Expected<Ranking> rank(const std::string& rows) const {
    const auto loops = read_ranked_loops(folder_.write("loops.csv", kHeader + rows));
    if (!loops) return loops.error();
    const auto verdicts = correct_loops(gt_, gt_info_, proposals_, {});
    if (!verdicts) return verdicts.error();
    return rank_loops(*verdicts, proposals_, *loops);
  }
  test::TemporaryFolder folder_;
  std::vector<LogRecord> gt_, proposals_;
  std::vector<InfoRecord> gt_info_;
};

TEST_F(LoopRanking, CountsAlongTheList) {
  const auto ranking = rank(
      "0,0,2,0.1,2,0.1,0.2,rejected,worse,9\n"
      "1,0,3,0.1,1,,,rejected,worse,9\n"
      "2,0,3,0.1,0,0.1,0.2,accepted,better,9\n"
      "3,1,5,,-1,,,rejected,not tested,9\n"
      "4,4,5,0.1,3,,,rejected,worse,9\n");
  ASSERT_TRUE(ranking.ok()) << ranking.error().message;
  ASSERT_EQ(ranking->points.size(), 3U) << "neighbours and unranked loops are left out";
  const auto& p = ranking->points;
  EXPECT_EQ(p[0].loop.id, 2);
  EXPECT_TRUE(p[0].loop.accepted);
  EXPECT_TRUE(p[0].correct);
  EXPECT_FALSE(p[1].correct);
  EXPECT_FALSE(p[1].loop.accepted);
  EXPECT_DOUBLE_EQ(p[0].precision, 1.0);
  EXPECT_DOUBLE_EQ(p[1].precision, 0.5);
  EXPECT_DOUBLE_EQ(p[2].precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(p[0].recall, 1.0 / 3);
  EXPECT_DOUBLE_EQ(p[2].recall, 2.0 / 3);
  EXPECT_NEAR(ranking->average_precision, 1.0 / 3 + 2.0 / 9, 1e-12);
}

TEST_F(LoopRanking, WrongFilesAreNamed) {
  EXPECT_THAT(rank("7,0,2,0.1,0,,,accepted,better,9\n").error().message, HasSubstr("loop 7 of the ranking"));
  EXPECT_THAT(rank("0,1,5,0.1,0,,,accepted,better,9\n").error().message, HasSubstr("of one run"));
  EXPECT_THAT(rank("0,0\n").error().message, HasSubstr("loops.csv:2"));
  EXPECT_THAT(rank("").error().message, HasSubstr("no loop that was scored"));
  EXPECT_THAT(read_ranked_loops(folder_.write("x.csv", "a,b\n")).error().message,
              HasSubstr("no column 'id'"));
  EXPECT_THAT(read_ranked_loops("/no/loops.csv").error().message, HasSubstr("cannot be opened"));
}

}  // namespace
}  // namespace loopsift
