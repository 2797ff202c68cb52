// SPDX-License-Identifier: MIT
// `loopsift-tool compare`: every filter has its row, and the figures are those of the loops that it kept.
#include <gmock/gmock.h>

#include <map>

#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/loopsift_tool/filters/filter.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class CompareCommand : public DeskSequence {
 protected:
  [[nodiscard]] std::vector<std::string> line() const {
    return with(sift_line("compare"), "--gt", path("gt.txt"));
  }
};

TEST_F(CompareCommand, OneRowPerFilter) {
  const DeskOutcome outcome = run_desk(line());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Json> rows;
  for (const Json& row : json()) {
    rows[row["filter"]] = row;
    EXPECT_THAT(outcome.out, HasSubstr(row["filter"].get<std::string>()));
    EXPECT_GE(row["wall_s"], 0.0);
  }
  ASSERT_EQ(rows.size(), published_filters().size() + 2);
  for (const NamedFilter& filter : published_filters()) EXPECT_EQ(rows.count(filter.name), 1U) << filter.name;

  EXPECT_EQ(rows["none"]["accepted"], 0);
  EXPECT_TRUE(rows["none"]["precision"].is_null());
  EXPECT_EQ(rows["none"]["recall"], 0.0);
  EXPECT_EQ(rows["all"]["accepted"], 2);
  EXPECT_EQ(rows["all"]["precision"], 0.5);
  EXPECT_EQ(rows["all"]["recall"], 1.0);
  for (const char* ours : {"loopsift", "loopsift_plain"}) {
    EXPECT_EQ(rows[ours]["accepted"], 1) << ours;
    EXPECT_EQ(rows[ours]["precision"], 1.0) << ours;
    EXPECT_EQ(rows[ours]["recall"], 1.0) << ours;
    EXPECT_LT(rows[ours]["ate_rmse_m"], rows["none"]["ate_rmse_m"]) << ours;
    EXPECT_LT(rows[ours]["dmp"], rows["none"]["dmp"]) << ours;
  }
}

TEST_F(CompareCommand, GroundTruthThatDoesNotFit) {
  EXPECT_EQ(run_desk(with(line(), "--gt", path("no.txt"))).exit_code, 2);
  Trajectory half = gt_;
  half.poses.resize(80);
  ASSERT_TRUE(write_trajectory_tum(path("half.txt"), half).ok());
  const DeskOutcome outcome = run_desk(with(line(), "--gt", path("half.txt")));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("no true pose for the first frame of fragment 10"));
}

}  // namespace
}  // namespace loopsift::tool
