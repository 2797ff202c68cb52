// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "core/geometry/trajectory.hpp"
#include "core/proposal/loop.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const char kIdentity[] = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
const char kUnitInfo[] = "1 0 0 0 0 0\n0 1 0 0 0 0\n0 0 1 0 0 0\n0 0 0 1 0 0\n0 0 0 0 1 0\n0 0 0 0 0 1\n";

Loop some_loop() {
  Loop loop;
  loop.i.value = 1;
  loop.j.value = 4;
  loop.T_i_j = test::motion(1, -2, 0.5, 0.3, 0.8, -0.4);
  const Matrix6d A = Matrix6d::Identity() * 3 + 0.3 * Matrix6d::Ones();
  loop.information = 100 * A * A.transpose();
  return loop;
}

TEST(LoopFiles, ComeBackAsWritten) {
  const test::TemporaryFolder folder;
  const Loop loop = some_loop();
  ASSERT_TRUE(write_loops(folder / "loops", {loop, loop}, 6));
  const auto read = read_loops(folder / "loops.log", folder / "loops.info", 6);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[1].id.value, 1);
  EXPECT_EQ((*read)[1].i, loop.i);
  EXPECT_EQ((*read)[1].j, loop.j);
  EXPECT_LT(((*read)[1].T_i_j.inverse() * loop.T_i_j).log().norm(), 1e-8);
  EXPECT_LT(((*read)[1].information - loop.information).norm(), 1e-8 * loop.information.norm());
}

TEST(LoopFiles, WithoutInformationClaimACentimetreAndHalfADegree) {
  const test::TemporaryFolder folder;
  const auto read = read_loops(folder.write("a.log", std::string("0 3 6\n") + kIdentity), "", 6);
  ASSERT_TRUE(read) << read.error().message;
  const Matrix6d covariance = read->at(0).information.inverse();
  EXPECT_NEAR(std::sqrt(covariance(1, 1)), 0.01, 1e-9);
  EXPECT_NEAR(std::sqrt(covariance(4, 4)) * 180 / 3.14159265358979, 0.5, 1e-9);
}

TEST(LoopFiles, ARecordFromLaterToEarlierIsTurnedRound) {
  const test::TemporaryFolder folder;
  const Loop loop = some_loop();
  ASSERT_TRUE(write_log(folder / "a.log", {{4, 1, 6, loop.T_i_j.inverse()}}));
  // Information of T_j_i is carried by the adjoint; turned round it must be the loop's again.
  const Matrix6d Ad = loop.T_i_j.inverse().adjoint();
  ASSERT_TRUE(write_info(folder / "a.info", {{4, 1, 6, Ad.transpose() * loop.information * Ad}}));
  const auto read = read_loops(folder / "a.log", folder / "a.info", 6);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->at(0).i.value, 1);
  EXPECT_EQ(read->at(0).j.value, 4);
  EXPECT_LT((read->at(0).T_i_j.inverse() * loop.T_i_j).log().norm(), 1e-8);
  EXPECT_LT((read->at(0).information - loop.information).norm(), 1e-6 * loop.information.norm());
}

class BadLoopFile : public ::testing::Test {
 protected:
  std::string error_of(const std::string& log, const std::string& info = "") {
    const std::string info_path = info.empty() ? "" : folder_.write("bad.info", info);
    const auto read = read_loops(folder_.write("bad.log", log), info_path, 6);
    return read ? "no error" : read.error().message;
  }
  test::TemporaryFolder folder_;
};

TEST_F(BadLoopFile, NamesAFragmentThatDoesNotExist) {
  EXPECT_THAT(
      error_of(std::string("0 2 6\n") + kIdentity + "3 17 6\n" + kIdentity),
      AllOf(HasSubstr("bad.log"), HasSubstr("record 2"), HasSubstr("no fragment 17"), HasSubstr("6")));
  EXPECT_THAT(error_of(std::string("-1 2 6\n") + kIdentity), HasSubstr("no fragment -1"));
}

TEST_F(BadLoopFile, NamesALoopFromAFragmentToItself) {
  EXPECT_THAT(error_of(std::string("2 2 6\n") + kIdentity),
              AllOf(HasSubstr("record 1"), HasSubstr("different")));
}

TEST_F(BadLoopFile, NamesATransformThatIsNone) {
  EXPECT_THAT(error_of("0 2 6\n1 0 0 0\n0 1 0 0\n0 0 9 0\n0 0 0 1\n"),
              AllOf(HasSubstr("bad.log"), HasSubstr("rigid")));
  EXPECT_THAT(error_of("0 2 6\n1 0 0 nan\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"), HasSubstr("bad.log"));
}

TEST_F(BadLoopFile, NamesAnInfoOfOtherLoops) {
  EXPECT_THAT(error_of(std::string("0 2 6\n") + kIdentity + "1 3 6\n" + kIdentity,
                       std::string("0 2 6\n") + kUnitInfo),
              AllOf(HasSubstr("bad.info"), HasSubstr("1 records"), HasSubstr("2")));
  EXPECT_THAT(error_of(std::string("0 2 6\n") + kIdentity, std::string("0 3 6\n") + kUnitInfo),
              AllOf(HasSubstr("bad.info"), HasSubstr("record 1"), HasSubstr("same loops")));
}

TEST_F(BadLoopFile, NamesTheMissingFile) {
  const auto read = read_loops(folder_ / "none.log", "", 6);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(read.error().message, HasSubstr("none.log"));
}

}  // namespace
}  // namespace loopsift
