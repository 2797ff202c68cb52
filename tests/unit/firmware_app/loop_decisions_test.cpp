// SPDX-License-Identifier: MIT
// Decisions about loops as a subscriber gets them: the publisher writes an LCM log, which is read back.
#include <gmock/gmock.h>
#include <lcm/eventlog.h>
#include <unistd.h>

#include <cstdio>
#include <loopsift/loop_t.hpp>

#include "firmware_app/back_worker.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift {
namespace {

std::vector<loop_t> read_decisions(const std::string& path) {
  std::vector<loop_t> decisions;
  lcm_eventlog_t* log = lcm_eventlog_create(path.c_str(), "r");
  if (log == nullptr) return decisions;
  while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
    if (event->channel == std::string("LOOPSIFT_LOOP")) {
      loop_t message{};
      EXPECT_EQ(message.decode(event->data, 0, event->datalen), event->datalen);
      decisions.push_back(message);
    }
    lcm_eventlog_free_event(event);
  }
  lcm_eventlog_destroy(log);
  return decisions;
}

/// A back end that has room for one loop, and a worker that publishes to a file.
struct Parts {
  Parts(const std::string& path, Arena& arena)
      : store(store_options(), arena),
        back_end(options(), arena),
        publisher(settings(path), arena),
        worker(back_end, store, publisher, arena) {}
  static BackEndOptions options() {
    BackEndOptions made;
    made.propose = made.calibrate_odometry = false;
    made.posterior.max_fragments = made.proposal.max_fragments = 8;
    made.posterior.max_view_width = 80, made.posterior.max_view_height = 60;
    made.sifter.max_loops = 1;
    return made;
  }
  static StoreOptions store_options() {
    StoreOptions made;
    made.max_fragments = 8;
    made.max_surfels = 200000;
    made.max_frames = made.max_views = 64;
    return made;
  }
  static LcmSettings settings(const std::string& path) {
    LcmSettings made;
    made.url = "file://" + path + "?mode=w";
    return made;
  }
  FragmentStore store;
  BackEnd back_end;
  Publisher publisher;
  BackWorker worker;
};

TEST(LoopDecisions, ALoopThatGaveWayIsPublishedAsDropped) {
  const std::string path = ::testing::TempDir() + "loop_decisions_" + std::to_string(getpid()) + ".lcmlog";
  const test::FragmentWorld world;
  {
    const test::InArena<Parts> parts(path);
    ASSERT_TRUE(parts->publisher.start().ok());
    BackWorker& worker = parts->worker;
    worker.start();
    auto close_next = [&, f = std::size_t{0}](std::size_t end) mutable {
      for (; f < end; ++f) {
        ASSERT_NE(parts->store.add(world.fragments()[f]), nullptr);
        worker.submit(world.fragments()[f].frames[3].timestamp_ns);
      }
      worker.wait_until_idle();  // now the back end is nobody's until the next submit
    };
    close_next(5);
    Vector6d far_off;
    far_off << 0.4, 0.2, 0, 0, 0, 0.3;
    for (const int id : {7, 8}) {
      const Loop loop = world.loop(id, 0, 4, far_off * (id - 6));
      parts->back_end.add_loops(Span<const Loop>(&loop, 1));
      close_next(static_cast<std::size_t>(id - 1));
    }
    worker.finish();
    parts->publisher.stop();
  }
  std::vector<loop_t> of_first, of_second;
  for (const loop_t& d : read_decisions(path)) (d.id == 7 ? of_first : of_second).push_back(d);
  std::remove(path.c_str());
  ASSERT_EQ(of_first.size(), 2U);
  EXPECT_EQ(of_first[0].decision, loop_t::REJECTED);
  EXPECT_EQ(of_first[1].decision, loop_t::DROPPED);
  EXPECT_EQ(of_first[1].reason, "no place for it (sifter.max_loops)");
  EXPECT_EQ(of_first[1].fragment_j, 4);
  EXPECT_EQ(of_first[1].frame_decided, 27) << "the newest when it gave way";
  ASSERT_EQ(of_second.size(), 1U);
  EXPECT_EQ(of_second[0].decision, loop_t::REJECTED);
}

}  // namespace
}  // namespace loopsift
