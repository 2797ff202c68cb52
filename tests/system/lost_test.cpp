// SPDX-License-Identifier: MIT
// The odometry is lost for two seconds while the camera goes on, and begins anew where it was: what comes
// after is a piece of trajectory whose place in the map nobody knows, until the camera comes back to what it
// saw before and a loop is accepted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/eventlog.h>

#include <bot_core/pose_t.hpp>
#include <cmath>
#include <loopsift/graph_t.hpp>
#include <loopsift/health_t.hpp>
#include <loopsift/pose_t.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/geometry/trajectory.hpp"
#include "loopsift/client/map.hpp"
#include "tests/support/program.hpp"
#include "tools/evaluation/trajectory_error.hpp"

namespace loopsift {
namespace {

using test::Outcome;

constexpr const char* kScene = "room?width=160&height=120&color=0&rate=15";
constexpr std::size_t kLost = 210, kFoundAgain = 240;  // frames, at 15 Hz
constexpr double kFoundAgain_s = kFoundAgain / 15.0;

class Lost : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        test::run_program({LOOPSIFT_TOOL, "synth", kScene, "--no-images", "--out", path("truth")});
    ASSERT_EQ(made.exit_code, 0) << made.output;
    const auto truth = read_trajectory(path("truth/groundtruth.txt"));
    ASSERT_TRUE(truth.ok());
    truth_ = *truth;
    ASSERT_GT(truth_.poses.size(), kFoundAgain);
    ASSERT_TRUE(write_trajectory_tum(path("odometry.txt"), broken_odometry()).ok());
  }
  void run(const std::string& setting) {
    const Outcome ran =
        test::run_program({LOOPSIFT_PROGRAM, "--source", std::string("synth:") + kScene, "--odometry",
                           "file:" + path("odometry.txt"), "--rate", "max", "--out", path("out"), "--set",
                           "lcm.url=file://" + path("bus.log") + "?mode=w", "--set", "memory.cap_mib=100000",
                           "--set", "frame.reduction=1", "--set", setting});
    ASSERT_EQ(ran.exit_code, 0) << ran.output;
    ASSERT_THAT(ran.output, ::testing::HasSubstr("starts a new piece of the map"));
    read_bus();
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() + "/" + name; }

  /// The truth, with a hole, and after it as if the camera had not moved meanwhile.
  [[nodiscard]] Trajectory broken_odometry() const {
    const Se3 T_odom_world =
        truth_.poses[kLost - 1].T_world_camera * truth_.poses[kFoundAgain].T_world_camera.inverse();
    Trajectory broken;
    for (std::size_t k = 0; k < truth_.poses.size(); ++k) {
      if (k >= kLost && k < kFoundAgain) continue;
      broken.poses.push_back(truth_.poses[k]);
      if (k >= kFoundAgain)
        broken.poses.back().T_world_camera = T_odom_world * truth_.poses[k].T_world_camera;
    }
    return broken;
  }
  void read_bus() {
    lcm_eventlog_t* log = lcm_eventlog_create(path("bus.log").c_str(), "r");
    ASSERT_NE(log, nullptr);
    while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
      const std::string channel = event->channel;
      if (channel == "POSE") take<bot_core::pose_t>(*event, &pose_);
      if (channel == "POSE_ODOM") take<bot_core::pose_t>(*event, &pose_odom_);
      if (channel == "LOOPSIFT_POSE") take<pose_t>(*event, &full_);
      if (channel == "LOOPSIFT_HEALTH") take<health_t>(*event, &health_);
      if (channel == "LOOPSIFT_GRAPH") take_graph(*event);
      lcm_eventlog_free_event(event);
    }
    lcm_eventlog_destroy(log);
  }
  template <class Message>
  static void take(const lcm_eventlog_event_t& event, std::map<std::int64_t, Message>* messages) {
    Message message{};
    ASSERT_EQ(message.decode(event.data, 0, event.datalen), event.datalen);
    (*messages)[message.utime] = message;
  }
  /// Counts, of each graph that is whole, the fragments of the new piece that are in the map and those that
  /// are not.
  void take_graph(const lcm_eventlog_event_t& event) {
    graph_t message{};
    ASSERT_EQ(message.decode(event.data, 0, event.datalen), event.datalen);
    const std::int32_t version = map_.graph().version;
    ASSERT_TRUE(map_.add(message));
    if (map_.graph().version == version) return;
    pieces_.push_back({});
    for (const graph_fragment_t& fragment : map_.graph().fragments) {
      if (static_cast<double>(fragment.first_frame_ns) * 1e-9 < kFoundAgain_s - 0.01) {
        EXPECT_TRUE(fragment.anchored) << "in version " << message.version;
      } else {
        ++(fragment.anchored ? pieces_.back().in_the_map : pieces_.back().outside);
      }
    }
  }
  /// Of a corrected pose, in metres, from where the camera truly was.
  [[nodiscard]] double error_m(const pose_t& pose) const {
    Se3 T_world_camera;
    EXPECT_TRUE(truth_.at(static_cast<double>(pose.utime) * 1e-6, 0.05, &T_world_camera));
    const double* t =
        pose.T_map_body.trans;  // X forward, Y left, Z up; the odometry given starts in the world
    return (T_world_camera.translation() - Eigen::Vector3d(-t[1], -t[2], t[0])).norm();
  }
  /// RMS distance from the truth of a written trajectory after the loss, in the world of its first part.
  [[nodiscard]] double error_after_m(const std::string& name) const {
    const auto trajectory = read_trajectory(path(name));
    EXPECT_TRUE(trajectory.ok());
    const auto pairs = associate(truth_, *trajectory, {});
    EXPECT_TRUE(pairs.ok());
    std::vector<PosePair> before;
    for (const PosePair& pair : *pairs)
      if (pair.time_s < kFoundAgain_s) before.push_back(pair);
    const Se3 T_gt_est = align(before);
    double sum = 0, count = 0;
    for (const PosePair& pair : *pairs) {
      if (pair.time_s < kFoundAgain_s) continue;
      sum += (T_gt_est * pair.T_est_camera.translation() - pair.T_gt_camera.translation()).squaredNorm();
      ++count;
    }
    EXPECT_GT(count, 0);
    return std::sqrt(sum / count);
  }

  test::TemporaryFolder folder_;
  Trajectory truth_;
  std::map<std::int64_t, bot_core::pose_t> pose_, pose_odom_;  // by utime
  std::map<std::int64_t, pose_t> full_;
  std::map<std::int64_t, health_t> health_;
  client::Map map_;
  struct NewPiece {
    int in_the_map = 0, outside = 0;  // fragments
  };
  std::vector<NewPiece> pieces_;  // in each version of the graph
};

TEST_F(Lost, TheNewPieceIsNotInTheMapWhileNoLoopJoinsIt) {
  run("proposal.enabled=false");
  ASSERT_FALSE(pieces_.empty());
  EXPECT_GT(pieces_.back().outside, 0);
  for (const NewPiece& piece : pieces_) EXPECT_EQ(piece.in_the_map, 0);
}

TEST_F(Lost, TheNewPieceIsNotPublishedInTheMapUntilALoopJoinsItAndIsRightThen) {
  run("fragment.view_step=4");
  const nlohmann::json figures = nlohmann::json::parse(test::read_file(path("out/run.json")));
  EXPECT_EQ(figures["frames"]["lost"], kFoundAgain - kLost);
  int not_known = 0, joined_again = 0;
  double worst_m = 0;
  for (const auto& [utime, full] : full_) {
    EXPECT_EQ(pose_odom_.count(utime), 1U) << "the odometry goes on";
    EXPECT_EQ(pose_.count(utime), full.anchored ? 1U : 0U) << "at " << utime << " us";
    EXPECT_EQ(full.piece, static_cast<double>(utime) * 1e-6 < kFoundAgain_s - 0.01
                              ? 0
                              : static_cast<std::int32_t>(kFoundAgain));
    not_known += full.anchored ? 0 : 1;
    if (full.piece == 0 || !full.anchored) continue;
    ++joined_again;
    worst_m = std::max(worst_m, error_m(full));
  }
  EXPECT_GT(not_known, 0);
  ASSERT_GT(joined_again, 0) << "no loop joined the new piece before the end";
  EXPECT_LT(worst_m, 0.2);
  EXPECT_LT(error_after_m("out/trajectory.txt"), 0.05);
  EXPECT_GT(error_after_m("out/trajectory_odometry.txt"), 0.3) << "nobody saw the motion in between";
  ASSERT_FALSE(pieces_.empty());
  for (const NewPiece& piece : pieces_) EXPECT_TRUE(piece.in_the_map == 0 || piece.outside == 0);
  EXPECT_GT(pieces_.back().in_the_map, 0);
  for (const auto& [utime, health] : health_) {
    if (health.frames_lost == 0) continue;
    EXPECT_EQ(health.lost_reason, health_t::NO_POSE) << "at " << utime << " us";
  }
}

}  // namespace
}  // namespace loopsift
