// SPDX-License-Identifier: MIT
// What goes wrong with a camera is seen from outside: each fault of a recording in the program's log, in its
// health and by the poses that are not sent.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/eventlog.h>

#include <algorithm>
#include <bot_core/pose_t.hpp>
#include <fstream>
#include <functional>
#include <loopsift/health_t.hpp>
#include <loopsift/pose_t.hpp>
#include <map>
#include <string>
#include <vector>

#include "drivers/synth/synth_sequence.hpp"
#include "tests/support/program.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWidth = 160, kHeight = 120, kFault = 30;  // the fault begins at this frame

// Frame k as it is written: what a fault may spoil.
struct Taken {
  int k = 0;
  std::int64_t time_us = 0;
  test::DepthImage depth{kWidth, kHeight};
  test::ColorImage color{kWidth, kHeight};
  bool has_color = true, dropped = false;
};
using Fault = std::function<void(Taken*)>;

bool within(const Taken& taken, int frames) { return taken.k >= kFault && taken.k < kFault + frames; }

Fault depth_of(std::uint16_t value) {
  return [value](Taken* taken) {
    if (within(*taken, 3)) std::fill(taken->depth.pixels.begin(), taken->depth.pixels.end(), value);
  };
}

class FaultsSeen : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto sequence = make_synth_sequence("room?width=160&height=120&frames=110", {});
    ASSERT_TRUE(sequence.ok());
    auto renderer = SequenceRenderer::create(*sequence);
    ASSERT_TRUE(renderer.ok());
    camera = sequence->settings.camera;
    RenderedFrame scratch;
    for (std::size_t k = 0; k < (*renderer)->size(); ++k) {
      Taken taken;
      taken.k = static_cast<int>(k);
      taken.time_us = std::llround((*renderer)->time_s(k) * 1e6);
      (*renderer)->render(k, &scratch, taken.depth.view(), taken.color.view());
      clean.push_back(std::move(taken));
    }
  }
  static void TearDownTestSuite() { clean.clear(); }

  void run(const Fault& fault) {
    std::vector<test::KlgFrame> frames;
    for (Taken taken : clean) {
      fault(&taken);
      if (taken.dropped) continue;
      frames.push_back({taken.time_us, test::raw_bytes(taken.depth),
                        taken.has_color ? test::raw_bytes(taken.color) : std::vector<std::uint8_t>()});
    }
    test::write_klg(path("a.klg"), frames);
    std::ofstream(path("camera.txt"))
        << "fx " << camera.fx << "\nfy " << camera.fy << "\ncx " << camera.cx << "\ncy " << camera.cy
        << "\nwidth " << kWidth << "\nheight " << kHeight << "\ndepth_scale 1000\n";
    const test::Outcome ran = test::run_program(
        {LOOPSIFT_PROGRAM, "--source", "replay:klg:" + path("a.klg"), "--rate", "max", "--set",
         "lcm.url=file://" + path("bus.log") + "?mode=w", "--set", "memory.cap_mib=100000", "--set",
         "frame.reduction=1", "--set", "fragment.view_step=4", "--set", "proposal.enabled=false"});
    ASSERT_EQ(ran.exit_code, 0) << ran.output;
    log_ = ran.output;
    read_bus();
  }
  void read_bus() {
    lcm_eventlog_t* log = lcm_eventlog_create(path("bus.log").c_str(), "r");
    ASSERT_NE(log, nullptr);
    while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
      const std::string channel = event->channel;
      if (channel == "LOOPSIFT_HEALTH") {
        ASSERT_EQ(health_.decode(event->data, 0, event->datalen), event->datalen);
      } else if (channel == "LOOPSIFT_POSE") {
        pose_t pose{};
        ASSERT_EQ(pose.decode(event->data, 0, event->datalen), event->datalen);
        poses_[pose.utime] = pose;
      } else if (channel == "POSE") {
        bot_core::pose_t pose{};
        ASSERT_EQ(pose.decode(event->data, 0, event->datalen), event->datalen);
        mapped_[pose.utime] = pose;
      }
      lcm_eventlog_free_event(event);
    }
    lcm_eventlog_destroy(log);
  }
  // Whether a pose of frame k went out; one may be missing on a busy machine, where the publisher drops some.
  [[nodiscard]] bool has_pose(int k) const {
    return poses_.count(clean[static_cast<std::size_t>(k)].time_us) > 0;
  }
  void expect_lost(int frames, int reason, const std::string& words) const {
    EXPECT_EQ(health_.frames_lost, frames);
    EXPECT_EQ(static_cast<int>(health_.lost_reason), reason);
    EXPECT_THAT(log_, HasSubstr("tracking lost at frame " + std::to_string(kFault) + ": " + words));
    for (int k = kFault; k < kFault + frames; ++k) EXPECT_FALSE(has_pose(k)) << k;
    EXPECT_EQ(health_.frames_tracked, static_cast<std::int64_t>(clean.size()) - frames);
  }
  void expect_tracked_throughout() const {
    EXPECT_EQ(health_.frames_lost, 0);
    EXPECT_EQ(static_cast<int>(health_.lost_reason), static_cast<int>(health_t::NONE));
    EXPECT_TRUE(health_.anchored);
    EXPECT_THAT(log_, Not(HasSubstr("tracking lost")));
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() + "/" + name; }

  static std::vector<Taken> clean;
  static PinholeCamera camera;
  test::TemporaryFolder folder_;
  std::string log_;
  health_t health_{};  // the last one
  std::map<std::int64_t, pose_t> poses_;
  std::map<std::int64_t, bot_core::pose_t> mapped_;
};
std::vector<Taken> FaultsSeen::clean;
PinholeCamera FaultsSeen::camera;

// An image of integers has no NaN: 0 is what stands for it, as a driver for floats writes it.
TEST_F(FaultsSeen, NoDepthAtAll) {
  for (const std::uint16_t value : {0, 65535}) {
    run(depth_of(value));
    expect_lost(3, health_t::NO_DEPTH, "too little depth");
    EXPECT_THAT(log_, HasSubstr("tracking again at frame " + std::to_string(kFault + 3)));
    EXPECT_TRUE(health_.anchored);
  }
}

TEST_F(FaultsSeen, ATimeStampTwiceAndOneThatGoesBack) {
  run([](Taken* taken) {
    if (taken->k == kFault) taken->time_us = clean[kFault - 1].time_us;
    if (taken->k == kFault + 1) taken->time_us = clean[kFault - 10].time_us;
  });
  expect_tracked_throughout();
  EXPECT_EQ(health_.frames_dropped, 2);
  for (const int k : {kFault, kFault + 1})
    EXPECT_THAT(log_, HasSubstr("frame " + std::to_string(k) + ": its time stamp does not go forward"));
}

// Found again, or said to be lost: never a pose in the map that nobody can vouch for.
TEST_F(FaultsSeen, ABurstOf30FramesMissing) {
  run([](Taken* taken) { taken->dropped = within(*taken, 30); });
  EXPECT_EQ(health_.frames_tracked + health_.frames_lost, 80);
  EXPECT_FALSE(has_pose(kFault));
  if (health_.frames_lost == 0) return;
  EXPECT_NE(static_cast<int>(health_.lost_reason), static_cast<int>(health_t::NONE));
  EXPECT_THAT(log_, HasSubstr("tracking lost at frame " + std::to_string(kFault) + ": "));
}

TEST_F(FaultsSeen, ColourGoesMissingHalfWay) {
  run([](Taken* taken) { taken->has_color = taken->k < kFault; });
  expect_tracked_throughout();
  EXPECT_EQ(health_.frames_tracked, static_cast<std::int64_t>(clean.size()));
}

TEST_F(FaultsSeen, ExposureFlashes) {
  run([](Taken* taken) {
    if (taken->k < kFault || taken->k % 7 != 0) return;
    for (Rgb8& c : taken->color.pixels)
      for (unsigned char* value : {&c.r, &c.g, &c.b})
        *value = static_cast<unsigned char>(std::min(255, 4 * *value));
  });
  expect_tracked_throughout();
  EXPECT_EQ(health_.frames_tracked, static_cast<std::int64_t>(clean.size()));
}

TEST_F(FaultsSeen, ALensCoveredForTwoSeconds) {
  run([](Taken* taken) {
    if (!within(*taken, 60)) return;
    std::fill(taken->depth.pixels.begin(), taken->depth.pixels.end(), std::uint16_t{0});
    std::fill(taken->color.pixels.begin(), taken->color.pixels.end(), Rgb8{});
  });
  expect_lost(60, health_t::NO_DEPTH, "too little depth");
  const int again = kFault + 60;
  EXPECT_THAT(log_, HasSubstr("frame " + std::to_string(again) + " starts a new piece of the map"));
  EXPECT_FALSE(health_.anchored) << "no loop joins the new piece here";
  const std::int64_t again_us = clean[again].time_us;
  for (const auto& [utime, pose] : poses_) {
    EXPECT_EQ(pose.anchored, utime < again_us) << "at " << utime << " us";
    EXPECT_EQ(pose.piece, utime < again_us ? 0 : again);
    EXPECT_TRUE(utime < again_us || mapped_.count(utime) == 0) << "its place in the map is not known";
  }
}

}  // namespace
}  // namespace loopsift
