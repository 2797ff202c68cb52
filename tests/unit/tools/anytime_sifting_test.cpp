// SPDX-License-Identifier: MIT
// Sifting under a limit, stopped at many places: there is always a map of the loops accepted so far.
#include "tools/loopsift_tool/anytime_sifting.hpp"

#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/loopsift_tool/offline_map.hpp"

namespace loopsift::tool {
namespace {

class AnytimeSifting : public DeskSequence {
 protected:
  static constexpr int kLoops = 20;

  void SetUp() override {
    DeskSequence::SetUp();
    std::vector<Se3> motions;
    const Se3 wrong(so3_exp({0, 0.35, 0}), {0.4, 0.1, -0.4});
    for (int k = 0; k < kLoops; ++k) {
      const Se3 near = true_motion(kTrueI, kTrueJ) * Se3::exp(Vector6d::Constant(1e-4 * k));
      motions.push_back(k % 2 == 0 ? near : near * wrong);
    }
    write_loops_of(motions);
    loops_ = read_loops(path("loops.log"), path("loops.info"), 16).value();
    const SourceOptions as_it_is;
    const auto source = open_source(kSource, as_it_is);
    const auto odometry = GivenOdometry::open(path("drift.txt"), "");
    OfflineMapOptions options;
    options.fragment_frames = kFragmentFrames;
    auto map = OfflineMap::build(**source, *odometry, options);
    ASSERT_TRUE(map.ok()) << map.error().message;
    map_ = std::move(*map);
  }
  /// Sifts until the limit has been asked for so often.
  std::unique_ptr<DetachedBackEnd> stopped_after(int questions, bool* is_batch) const {
    auto back_end = map_->make_back_end(ScoreKind::kPosterior, 1.0);
    int asked = 0;
    *is_batch =
        sift_within([&] { return asked++ < questions ? 1e9 : 0.0; }, loops_, &**back_end, [](auto, auto) {});
    return back_end;
  }

  std::vector<Loop> loops_;
  std::unique_ptr<OfflineMap> map_;
};

TEST_F(AnytimeSifting, TheMapIsThatOfTheLoopsAcceptedSoFar) {
  bool some_pending_with_a_map = false;
  for (const int questions : {0, 1, 7, 11, 13, 20, 35, 60}) {
    bool is_batch = false;
    const auto back_end = stopped_after(questions, &is_batch);
    const Sifter& sifter = (*back_end)->sifter();
    EXPECT_EQ(sifter.records().size(), static_cast<std::size_t>(kLoops)) << questions;
    std::size_t accepted = 0;
    for (const SiftedLoop& record : sifter.records()) {
      EXPECT_EQ(record.decision == Decision::kAccepted, record.published) << questions;
      accepted += record.decision == Decision::kAccepted ? 1 : 0;
    }
    EXPECT_EQ(sifter.accepted().size(), accepted) << questions;
    for (const Loop& loop : sifter.accepted()) EXPECT_EQ(loop.id.value % 2, 0) << "a wrong one";
    if (accepted > 0) {
      EXPECT_LT((*back_end)->dmp_final(), (*back_end)->dmp_odometry()) << questions;
    }
    some_pending_with_a_map |= accepted > 0 && sifter.pending() > 0;
    if (questions == 0) {
      EXPECT_EQ(sifter.pending(), kLoops);
    }
  }
  EXPECT_TRUE(some_pending_with_a_map) << "the first map came only with the last decision";
}

TEST_F(AnytimeSifting, WithTimeLeftItIsTheBatchResult) {
  bool is_batch = false;
  const auto anytime = stopped_after(1 << 30, &is_batch);
  EXPECT_TRUE(is_batch);
  const auto batch = map_->make_back_end(ScoreKind::kPosterior, 1.0);
  (*batch)->add_loops(loops_);
  ASSERT_TRUE((*batch)->finish());
  const auto ids = [](const std::vector<Loop>& loops) {
    std::vector<int> values;
    for (const Loop& loop : loops) values.push_back(loop.id.value);
    return values;
  };
  EXPECT_FALSE((*batch)->sifter().accepted().empty());
  EXPECT_EQ(ids((*anytime)->sifter().accepted()), ids((*batch)->sifter().accepted()));
  EXPECT_EQ((*anytime)->dmp_final(), (*batch)->dmp_final());
}

}  // namespace
}  // namespace loopsift::tool
