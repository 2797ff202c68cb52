// SPDX-License-Identifier: MIT
// What a comparison is made of: truth, false loops, tasks on all cores.
#include <gmock/gmock.h>

#include <atomic>
#include <stdexcept>

#include "tests/support/temporary_folder.hpp"
#include "tools/loopsift_tool/comparison/false_loops.hpp"
#include "tools/loopsift_tool/comparison/task_pool.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

TEST(TaskPool, RunsEachTaskOnce) {
  std::vector<std::atomic<int>> runs(50);
  std::vector<std::function<void()>> tasks;
  for (std::atomic<int>& count : runs) tasks.emplace_back([&count] { ++count; });
  run_tasks("test", tasks);
  for (const std::atomic<int>& count : runs) EXPECT_EQ(count, 1);
  run_tasks("nothing", {});
}

TEST(TaskPool, PassesOnWhatATaskThrows) {
  std::atomic<int> others{0};
  std::vector<std::function<void()>> tasks(10, [&others] { ++others; });
  tasks[3] = [] { throw std::runtime_error("no memory"); };
  EXPECT_THROW(run_tasks("test", tasks), std::runtime_error);
  EXPECT_EQ(others, 9);
}

// Ten fragments of one frame on a circle, and their true trajectory.
class ComparisonTruth : public ::testing::Test {
 protected:
  static constexpr int kFragments = 10;
  void SetUp() override {
    std::vector<LogRecord> records;
    for (int k = 0; k < kFragments; ++k) {
      const double angle = 0.5 * k;
      const Se3 T(so3_exp({0, 0, angle}), Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.1 * k));
      records.push_back({k, k, k + 1, T});
      FragmentFrame frame;
      frame.frame = FrameId{k};
      frames_.push_back({frame});
    }
    for (int k = 0; k < kFragments; ++k) {
      Fragment fragment;
      fragment.id = FragmentId{k};
      fragment.frames = Span<const FragmentFrame>(frames_[static_cast<std::size_t>(k)]);
      fragments_.push_back(fragment);
    }
    ASSERT_TRUE(write_log(folder_ / "gt.log", records).ok());
    loops_ = {loop(0, 2, 5, 0.0), loop(1, 1, 8, 0.05), loop(7, 3, 6, 0.3)};
  }
  [[nodiscard]] Loop loop(int id, int i, int j, double off_m) const {
    Loop loop;
    loop.id = LoopId{id};
    loop.i = FragmentId{i};
    loop.j = FragmentId{j};
    loop.T_i_j = *truth().motion(fragments_, loop.i, loop.j) *
                 Se3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(off_m, 0, 0));
    loop.information = (1.0 + id) * Matrix6d::Identity();
    return loop;
  }
  [[nodiscard]] Truth truth() const { return *Truth::read({folder_ / "gt.log", "", ""}); }

  test::TemporaryFolder folder_;
  std::vector<std::vector<FragmentFrame>> frames_;
  std::vector<Fragment> fragments_;
  std::vector<Loop> loops_;
};

TEST_F(ComparisonTruth, TrueLoopsByTheTrajectory) {
  const auto ids = truth().true_loops(loops_, fragments_);
  ASSERT_TRUE(ids.ok()) << ids.error().message;
  EXPECT_EQ(*ids, (std::set<int>{0, 1}));
}

TEST_F(ComparisonTruth, LabelsDecideWhereThereAreAny) {
  ASSERT_TRUE(write_log(folder_ / "l.log", {{2, 5, 10, loops_[0].T_i_j}, {3, 6, 10, loops_[2].T_i_j}}).ok());
  ASSERT_TRUE(
      write_info(folder_ / "l.info", {{2, 5, 10, Matrix6d::Identity()}, {3, 6, 10, Matrix6d::Identity()}})
          .ok());
  const auto labelled = Truth::read({folder_ / "gt.log", folder_ / "l.log", folder_ / "l.info"});
  ASSERT_TRUE(labelled.ok()) << labelled.error().message;
  const auto ids = labelled->true_loops(loops_, fragments_);
  ASSERT_TRUE(ids.ok());
  EXPECT_EQ(*ids, (std::set<int>{0, 7}));  // 1–8 has no label; the label of 3–6 agrees with the loop
  ASSERT_TRUE(write_info(folder_ / "l.info", {{2, 5, 10, Matrix6d::Identity()}}).ok());
  const auto short_info = Truth::read({"", folder_ / "l.log", folder_ / "l.info"});
  ASSERT_FALSE(short_info.ok());
  EXPECT_THAT(short_info.error().message, HasSubstr("l.info: has 1 records"));
}

TEST_F(ComparisonTruth, FalseLoopsAreFalseAndTheSameForTheSameSeed) {
  const auto wrong = make_false_loops(loops_, truth(), fragments_, 60, 5);
  ASSERT_TRUE(wrong.ok()) << wrong.error().message;
  ASSERT_EQ(wrong->size(), 60U);
  EXPECT_TRUE(truth().true_loops(*wrong, fragments_)->empty());
  std::set<int> ids;
  for (const Loop& l : *wrong) {
    ids.insert(l.id.value);
    EXPECT_LT(l.i.value, l.j.value);
    EXPECT_LT(l.j.value, kFragments);
    EXPECT_TRUE(l.T_i_j.is_valid());
  }
  EXPECT_EQ(ids.size(), 60U);
  EXPECT_EQ(*ids.begin(), 8);
  const auto again = make_false_loops(loops_, truth(), fragments_, 60, 5);
  const auto other = make_false_loops(loops_, truth(), fragments_, 60, 6);
  ASSERT_TRUE(again.ok() && other.ok());
  EXPECT_EQ((*again)[59].T_i_j.matrix(), (*wrong)[59].T_i_j.matrix());
  EXPECT_NE((*other)[59].T_i_j.matrix(), (*wrong)[59].T_i_j.matrix());
}

TEST_F(ComparisonTruth, FalseLoopsNeedLoopsAndFragments) {
  EXPECT_FALSE(make_false_loops({}, truth(), fragments_, 1, 1).ok());
  fragments_.resize(3);
  EXPECT_FALSE(make_false_loops(loops_, truth(), fragments_, 1, 1).ok());
}

}  // namespace
}  // namespace loopsift::tool
