// SPDX-License-Identifier: MIT
#include "firmware_app/back_worker.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;

LcmSettings silent() {
  LcmSettings settings;
  settings.enabled = false;
  return settings;
}

BackEndOptions options() {
  BackEndOptions made;
  made.propose = false;  // loops are handed in: what is tested here are the threads
  made.calibrate_odometry = false;
  made.posterior.max_fragments = made.proposal.max_fragments = 8;
  made.posterior.max_view_width = 80, made.posterior.max_view_height = 60;
  return made;
}

StoreOptions small_store() {
  StoreOptions made;
  made.max_fragments = 8;
  made.max_surfels = 200000;
  made.max_frames = made.max_views = 64;
  return made;
}

// As the program wires them: a store that the front thread fills, a back end, a worker.
struct Parts {
  explicit Parts(Arena& arena) : Parts(BackWorkerOptions{}, arena) {}
  Parts(const BackWorkerOptions& of_worker, Arena& arena)
      : store(small_store(), arena),
        back_end(options(), arena),
        publisher(silent(), arena),
        worker(back_end, store, publisher, arena, of_worker) {}
  FragmentStore store;
  BackEnd back_end;
  Publisher publisher;
  BackWorker worker;
};

class BackWorkerTest : public ::testing::Test {
 protected:
  void close_fragment(std::size_t f) {
    ASSERT_NE(parts_->store.add(world_.fragments()[f]), nullptr);
    parts_->worker.submit(world_.fragments()[f].frames[3].timestamp_ns);
  }
  FragmentWorld world_;
  InArena<Parts> parts_;
};

TEST_F(BackWorkerTest, WorksOffWhatIsSubmitted) {
  BackWorker& worker = parts_->worker;
  worker.start();
  for (std::size_t f = 0; f < 7; ++f) close_fragment(f);
  worker.wait_until_idle();
  EXPECT_EQ(worker.backlog(), 0);
  EXPECT_EQ(parts_->back_end.fragment_count(), 7);
  CorrectionRecord correction;
  EXPECT_FALSE(worker.take(&correction)) << "without a loop there is nothing to correct";
  worker.finish();
}

TEST_F(BackWorkerTest, CorrectionsArriveWithTheirEpoch) {
  BackWorker& worker = parts_->worker;
  worker.start();
  for (std::size_t f = 0; f < 6; ++f) close_fragment(f);
  worker.wait_until_idle();  // now the back end is nobody's until the next submit
  const Loop loop = world_.loop(0, 0, 5);
  parts_->back_end.add_loops(Span<const Loop>(&loop, 1));
  close_fragment(6);
  worker.wait_until_idle();
  EXPECT_EQ(worker.loops_proposed(), 1);
  EXPECT_EQ(worker.loops_accepted(), 1);
  CorrectionRecord correction;
  ASSERT_TRUE(worker.take(&correction));
  EXPECT_EQ(correction.epoch, 1);
  EXPECT_EQ(correction.frame_decided, 27);
  EXPECT_EQ(correction.piece, 0);
  EXPECT_TRUE(correction.anchored);
  EXPECT_GT(correction.T_map_odom.log().norm(), 0.01);
  EXPECT_FALSE(worker.take(&correction));

  worker.finish();
  ASSERT_TRUE(worker.take(&correction)) << "the end of a run says where everything came to lie";
  EXPECT_EQ(correction.epoch, 2);
  EXPECT_EQ(worker.correction_times().count(), 2);
}

TEST(BackWorkerSlice, InRealTimeWhatASliceDoesNotHoldIsLeftForTheEnd) {
  const FragmentWorld world;
  BackWorkerOptions one_step;
  one_step.realtime = true;
  one_step.slice_s = 0;
  const InArena<Parts> parts(one_step);
  BackWorker& worker = parts->worker;
  worker.start();
  for (std::size_t f = 0; f < 7; ++f) {
    const Loop loop = world.loop(0, 0, 5);
    if (f == 6) parts->back_end.add_loops(Span<const Loop>(&loop, 1));
    ASSERT_NE(parts->store.add(world.fragments()[f]), nullptr);
    worker.submit(world.fragments()[f].frames[3].timestamp_ns);
    worker.wait_until_idle();
  }
  const SiftedLoop& record = parts->back_end.sifter().records()[0];
  EXPECT_TRUE(record.scored) << "the one step";
  EXPECT_EQ(record.decision, Decision::kPending);
  EXPECT_EQ(worker.loops_accepted(), 0);
  worker.finish();
  EXPECT_EQ(record.decision, Decision::kAccepted);
  EXPECT_EQ(worker.loops_accepted(), 1);
}

// Loops to each new fragment, and nobody who takes the corrections that follow.
TEST_F(BackWorkerTest, CorrectionsThatFindTheRingFullAreReplacedByTheLast) {
  BackWorker& worker = parts_->worker;
  worker.start();
  int id = 0;
  for (std::size_t f = 0; f < 7; ++f) {
    worker.wait_until_idle();
    for (int i = 0; i + 2 < static_cast<int>(f); ++i) {
      const Loop loop = world_.loop(id++, i, static_cast<int>(f) - 1);
      parts_->back_end.add_loops(Span<const Loop>(&loop, 1));
    }
    close_fragment(f);
  }
  worker.finish();
  const auto corrections = static_cast<int>(worker.correction_times().count());
  const auto ring = static_cast<int>(BackWorker::kCorrections);
  ASSERT_GT(corrections, ring);
  EXPECT_EQ(worker.pools()[0].name, "back/corrections");
  EXPECT_EQ(worker.pools()[0].high_water, ring);
  EXPECT_GT(worker.pools()[0].refused, 0);
  CorrectionRecord correction;
  for (int epoch = 1; epoch <= ring; ++epoch) {
    ASSERT_TRUE(worker.take(&correction));
    EXPECT_EQ(correction.epoch, epoch);
  }
  ASSERT_TRUE(worker.take(&correction));
  EXPECT_EQ(correction.epoch, corrections) << "the last one says all that those before it said";
  EXPECT_FALSE(worker.take(&correction));
}

TEST_F(BackWorkerTest, MoreOrdersToSaveThanMayWaitAreRefused) {
  BackWorker& worker = parts_->worker;  // not started: they wait
  for (std::size_t k = 0; k < BackWorker::kSaves; ++k) EXPECT_TRUE(worker.request_save({}));
  EXPECT_FALSE(worker.request_save({}));
  EXPECT_EQ(worker.pools()[1].name, "back/saves");
  EXPECT_EQ(worker.pools()[1].refused, 1);
  worker.start();
  worker.finish();
}

// The worker is held inside the back end; the front thread must get through all the same.
TEST_F(BackWorkerTest, ASlowBackEndHoldsUpNoSubmit) {
  BackWorker& worker = parts_->worker;
  worker.start();
  for (std::size_t f = 0; f < 4; ++f) close_fragment(f);
  worker.wait_until_idle();
  const Loop loop = world_.loop(0, 0, 3);
  parts_->back_end.add_loops(Span<const Loop>(&loop, 1));
  Semaphore held, go_on;
  parts_->back_end.sifter().on_progress([&](std::size_t, std::size_t) {
    held.post();
    go_on.wait();
  });
  close_fragment(4);
  held.wait();
  close_fragment(5), close_fragment(6);
  EXPECT_EQ(worker.backlog(), 3);
  CorrectionRecord correction;
  EXPECT_FALSE(worker.take(&correction));
  for (int k = 0; k < 100; ++k) go_on.post();
  worker.finish();
  EXPECT_EQ(worker.backlog(), 0);
  EXPECT_EQ(parts_->back_end.fragment_count(), 7);
}

TEST_F(BackWorkerTest, FinishWorksOffTheBacklogFirst) {
  parts_->worker.start();
  for (std::size_t f = 0; f < 7; ++f) close_fragment(f);
  parts_->worker.finish();
  EXPECT_EQ(parts_->worker.backlog(), 0);
  EXPECT_EQ(parts_->back_end.fragment_count(), 7);
}

// Held inside the back end, as a thread that hangs would be.
TEST_F(BackWorkerTest, AQuickEndLeavesWhatWaitsAndFreesWhoeverWaits) {
  BackWorker& worker = parts_->worker;
  worker.start();
  for (std::size_t f = 0; f < 4; ++f) close_fragment(f);
  worker.wait_until_idle();
  const Loop loop = world_.loop(0, 0, 3);
  parts_->back_end.add_loops(Span<const Loop>(&loop, 1));
  Semaphore held, go_on;
  parts_->back_end.sifter().on_progress([&](std::size_t, std::size_t) {
    held.post();
    go_on.wait();
  });
  close_fragment(4);
  held.wait();
  close_fragment(5), close_fragment(6);
  worker.request_end(Ending::kQuick);
  worker.wait_until_idle();  // at rate max the front thread would wait here
  EXPECT_FALSE(worker.ended());
  for (int k = 0; k < 100; ++k) go_on.post();
  worker.join();
  EXPECT_TRUE(worker.ended());
  EXPECT_EQ(parts_->back_end.fragment_count(), 5) << "what was in work was ended, the rest left";
  EXPECT_FALSE(worker.disabled());
}

TEST_F(BackWorkerTest, AnAbandonedThreadHasNoEffectAnyMore) {
  BackWorker& worker = parts_->worker;
  worker.start();
  for (std::size_t f = 0; f < 6; ++f) close_fragment(f);
  worker.wait_until_idle();
  const Loop loop = world_.loop(0, 0, 5);
  parts_->back_end.add_loops(Span<const Loop>(&loop, 1));
  Semaphore held, go_on;
  parts_->back_end.sifter().on_progress([&](std::size_t, std::size_t) {
    held.post();
    go_on.wait();
  });
  close_fragment(6);
  held.wait();
  worker.abandon();
  worker.wait_until_idle();
  EXPECT_TRUE(worker.disabled());
  for (int k = 0; k < 100; ++k) go_on.post();
  worker.finish();
  CorrectionRecord correction;
  EXPECT_FALSE(worker.take(&correction)) << "the loop would have been accepted";
}

TEST_F(BackWorkerTest, FinishWithoutAnyFragmentEnds) {
  parts_->worker.start();
  parts_->worker.finish();
  CorrectionRecord correction;
  while (parts_->worker.take(&correction)) EXPECT_EQ(correction.T_map_odom.log().norm(), 0);
}

TEST_F(BackWorkerTest, EndsItsThreadWhenItGoesOutOfScope) {
  parts_->worker.start();
  close_fragment(0);
}  // the destructor joins; a thread left running would end the process

}  // namespace
}  // namespace loopsift
