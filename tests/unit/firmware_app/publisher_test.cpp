// SPDX-License-Identifier: MIT
// Messages as a subscriber gets them: the publisher writes an LCM log (file:// provider), which is read back
// and decoded.
#include "firmware_app/publisher.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <lcm/eventlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bot_core/pose_t.hpp>
#include <bot_frames/update_t.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <loopsift/command_t.hpp>
#include <loopsift/correction_t.hpp>
#include <loopsift/loop_t.hpp>
#include <loopsift/pose_t.hpp>
#include <thread>

namespace loopsift {
namespace {

using Channel = Publisher::Channel;
constexpr double kPi = 3.14159265358979323846;

struct Event {
  std::string channel;
  std::vector<char> data;
};

std::vector<Event> read_log(const std::string& path) {
  std::vector<Event> events;
  lcm_eventlog_t* log = lcm_eventlog_create(path.c_str(), "r");
  if (log == nullptr) return events;
  while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
    const char* data = static_cast<const char*>(event->data);
    events.push_back({event->channel, {data, data + event->datalen}});
    lcm_eventlog_free_event(event);
  }
  lcm_eventlog_destroy(log);
  return events;
}

template <class Message>
Message decode(const Event& event) {
  Message message{};
  EXPECT_EQ(message.decode(event.data.data(), 0, static_cast<int>(event.data.size())),
            static_cast<int>(event.data.size()))
      << event.channel;
  return message;
}

/// What was published after the update that start() sends.
std::vector<Event> read_after_start(const std::string& path) {
  std::vector<Event> events = read_log(path);
  EXPECT_FALSE(events.empty());
  if (events.empty()) return events;
  EXPECT_EQ(events[0].channel, "R2_LOOPSIFT_UPDATE");
  const auto update = decode<bot_frames::update_t>(events[0]);
  EXPECT_EQ(update.utime, 0);
  EXPECT_EQ(update.quat[0], 1);
  events.erase(events.begin());
  return events;
}

class PublisherTest : public ::testing::Test {
 protected:
  PublisherTest() {
    settings_.url = "file://" + path_ + "?mode=w";
    settings_.prefix = "R2_";
    Arena measuring;
    { const Publisher publisher(settings_, measuring); }
    bytes_ = measuring.used_bytes();
  }
  void TearDown() override { std::remove(path_.c_str()); }

  std::string path_ = ::testing::TempDir() + "publisher_test_" + std::to_string(getpid()) + ".lcmlog";
  LcmSettings settings_;
  std::size_t bytes_ = 0;
};

TEST_F(PublisherTest, PosesGoOutTwiceInBodyAxesWithVelocity) {
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  ASSERT_TRUE(publisher.start().ok());
  // The camera moves 0.1 m along its z and turns 0.02 rad to the left (about −y) in 0.1 s.
  PoseRecord record;
  record.timestamp_ns = 5'000'000'000;
  record.T_map_odom = Se3(Eigen::Matrix3d::Identity(), {0, -2, 0});  // 2 m up
  ASSERT_TRUE(publisher.publish(record));
  Vector6d motion;
  motion << 0, 0, 0.1, 0, -0.02, 0;
  record.timestamp_ns += 100'000'000;
  record.T_odom_camera = Se3::exp(motion);
  record.epoch = 4;
  record.information = Matrix6d::Identity() * 100;
  record.information(2, 2) = 25;
  ASSERT_TRUE(publisher.publish(record));
  publisher.stop();

  const std::vector<Event> events = read_after_start(path_);
  ASSERT_EQ(events.size(), 6U);
  EXPECT_EQ(events[3].channel, "R2_POSE_ODOM");
  EXPECT_EQ(events[4].channel, "R2_POSE");
  EXPECT_EQ(events[5].channel, "R2_LOOPSIFT_POSE");
  const auto first = decode<bot_core::pose_t>(events[0]);
  EXPECT_EQ(first.utime, 5'000'000);
  EXPECT_EQ(first.vel[0], 0);
  const auto odom = decode<bot_core::pose_t>(events[3]);
  EXPECT_EQ(odom.utime, 5'100'000);
  EXPECT_NEAR(odom.pos[0], 0.1, 1e-4);
  EXPECT_NEAR(odom.pos[1], 0.001, 1e-4);  // the arc bends left
  EXPECT_NEAR(odom.pos[2], 0, 1e-12);
  EXPECT_NEAR(odom.orientation[0], std::cos(0.01), 1e-12);
  EXPECT_NEAR(odom.orientation[3], std::sin(0.01), 1e-12);
  EXPECT_NEAR(odom.vel[0], 1.0, 1e-9);
  EXPECT_NEAR(odom.vel[1], 0.0, 1e-9);
  EXPECT_NEAR(odom.rotation_rate[2], 0.2, 1e-9);
  const auto corrected = decode<bot_core::pose_t>(events[4]);
  EXPECT_NEAR(corrected.pos[0], odom.pos[0], 1e-12);
  EXPECT_NEAR(corrected.pos[2], 2.0, 1e-12);
  EXPECT_NEAR(corrected.vel[0], 1.0, 1e-9);
  const auto full = decode<pose_t>(events[5]);
  EXPECT_EQ(full.utime, 5'100'000);
  EXPECT_EQ(full.epoch, 4);
  EXPECT_GT(full.run, 0);
  EXPECT_NEAR(full.T_odom_body.trans[0], odom.pos[0], 1e-12);
  EXPECT_NEAR(full.T_map_body.trans[2], 2.0, 1e-12);
  EXPECT_NEAR(full.covariance[0 * 6 + 0], 0.04, 1e-12);  // along the camera's z
  EXPECT_NEAR(full.covariance[1 * 6 + 1], 0.01, 1e-12);
  EXPECT_EQ(publisher.sent(Channel::kPose), 2);
  EXPECT_EQ(publisher.failed(), 0);
}

TEST_F(PublisherTest, ACorrectionCarriesJumpAndCovarianceAndComesBeforeItsPose) {
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  ASSERT_TRUE(publisher.start().ok());
  auto record = std::make_unique<CorrectionRecord>();
  record->timestamp_ns = 7'000'000'000;
  record->epoch = 3;
  record->frame_decided = 210;
  record->T_odom_camera = Se3(Eigen::Matrix3d::Identity(), {0, 0, 10});
  record->T_map_odom = Se3(Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitY()).toRotationMatrix(), {0, 0, 0});
  record->covariance_timestamp_ns = 7'000'000'000;
  record->covariance = Matrix6d::Zero();
  record->covariance(2, 2) = 4;  // along the camera's z, the body's X
  record->covariance(2, 3) = record->covariance(3, 2) = 0.5;
  PoseRecord pose;
  pose.timestamp_ns = 7'000'000'000;
  pose.T_odom_camera = record->T_odom_camera;
  ASSERT_TRUE(publisher.publish(pose));
  while (publisher.sent(Channel::kFullPose) == 0) std::this_thread::yield();
  ASSERT_TRUE(publisher.publish(*record));
  ASSERT_TRUE(publisher.publish(pose));
  publisher.stop();

  const std::vector<Event> events = read_after_start(path_);
  ASSERT_EQ(events.size(), 8U);
  EXPECT_EQ(events[3].channel, "R2_LOOPSIFT_CORRECTION");
  EXPECT_EQ(events[4].channel, "R2_LOOPSIFT_UPDATE");
  EXPECT_EQ(events[5].channel, "R2_POSE_ODOM");
  const auto correction = decode<correction_t>(events[3]);
  EXPECT_EQ(correction.utime, 7'000'000);
  EXPECT_EQ(correction.epoch, 3);
  EXPECT_EQ(correction.frame_decided, 210);
  EXPECT_NEAR(correction.jump_translation_m, 2 * 10 * std::sin(0.05), 1e-9);
  EXPECT_NEAR(correction.jump_rotation_rad, 0.1, 1e-9);
  EXPECT_NEAR(correction.T_map_odom.quat[0], std::cos(0.05), 1e-12);
  EXPECT_NEAR(correction.T_map_odom.quat[3], std::sin(0.05), 1e-12);
  EXPECT_NEAR(correction.covariance[0], 4, 1e-12);
  EXPECT_NEAR(correction.covariance[0 * 6 + 4], -0.5, 1e-12);  // camera x is the body's −Y
  const auto update = decode<bot_frames::update_t>(events[4]);
  EXPECT_EQ(update.frame, "odom");
  EXPECT_EQ(update.relative_to, "map");
  EXPECT_NEAR(update.quat[3], std::sin(0.05), 1e-12);
}

// After a loss, until an accepted loop says where it is.
TEST_F(PublisherTest, APoseThatIsNotKnownInTheMapDoesNotGoOutAsOne) {
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  ASSERT_TRUE(publisher.start().ok());
  PoseRecord pose;
  pose.timestamp_ns = 5'000'000'000;
  pose.piece = 120;
  pose.anchored = false;
  ASSERT_TRUE(publisher.publish(pose));
  while (publisher.sent(Channel::kFullPose) == 0) std::this_thread::yield();
  auto correction = std::make_unique<CorrectionRecord>();
  correction->epoch = 1;
  correction->anchored = false;
  ASSERT_TRUE(publisher.publish(*correction));
  publisher.stop();

  const std::vector<Event> events = read_after_start(path_);
  ASSERT_EQ(events.size(), 3U);
  EXPECT_EQ(events[0].channel, "R2_POSE_ODOM");
  ASSERT_EQ(events[1].channel, "R2_LOOPSIFT_POSE");
  const auto full = decode<pose_t>(events[1]);
  EXPECT_EQ(full.piece, 120);
  EXPECT_FALSE(full.anchored);
  EXPECT_TRUE(std::isnan(full.covariance[0]));
  ASSERT_EQ(events[2].channel, "R2_LOOPSIFT_CORRECTION") << "and no LOOPSIFT_UPDATE";
  EXPECT_FALSE(decode<correction_t>(events[2]).anchored);
  EXPECT_EQ(publisher.sent(Channel::kPose), 0);
}

TEST_F(PublisherTest, ALoopCarriesItsNumbers) {
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  ASSERT_TRUE(publisher.start().ok());
  LoopRecord record;
  record.id = 12;
  record.fragment_i = 2;
  record.fragment_j = 9;
  record.T_i_j = Se3(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {1, 2, 3});
  record.single_dmp = 14.5;
  record.rank = 4;
  record.decision = LoopDecision::kRevoked;
  record.reason.fill('x');  // not terminated
  record.frame_decided = 500;
  ASSERT_TRUE(publisher.publish(record));
  publisher.stop();

  const std::vector<Event> events = read_after_start(path_);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].channel, "R2_LOOPSIFT_LOOP");
  const auto loop = decode<loop_t>(events[0]);
  EXPECT_EQ(loop.id, 12);
  EXPECT_EQ(loop.fragment_i, 2);
  EXPECT_EQ(loop.fragment_j, 9);
  EXPECT_EQ(loop.T_i_j.trans[0], 3);
  EXPECT_EQ(loop.T_i_j.trans[1], -1);
  EXPECT_EQ(loop.T_i_j.trans[2], -2);
  EXPECT_NEAR(loop.T_i_j.quat[1], std::sin(kPi / 4), 1e-12);  // about the camera's z: roll
  EXPECT_EQ(loop.single_dmp, 14.5);
  EXPECT_TRUE(std::isnan(loop.tested_dmp));
  EXPECT_EQ(loop.decision, loop_t::REVOKED);
  EXPECT_EQ(loop.reason, std::string(63, 'x'));
  EXPECT_EQ(loop.frame_decided, 500);
}

TEST_F(PublisherTest, AFullRingDropsAndCountsAndNeverWaits) {
  std::signal(SIGPIPE, SIG_IGN);
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  const int reader =
      open(path_.c_str(), O_RDONLY | O_NONBLOCK);  // takes 64 kB, then the publish thread blocks
  ASSERT_GE(reader, 0);
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  ASSERT_TRUE(publisher.start().ok());
  auto record = std::make_unique<CorrectionRecord>();
  // However fast the publish thread is, it stops once the pipe is full; then the ring fills.
  constexpr int kMoreThanThePipeTakes = 100'000;
  int refused = 0;
  for (int i = 0; i < kMoreThanThePipeTakes && refused < 50; ++i)
    refused += publisher.publish(*record) ? 0 : 1;
  close(reader);  // the blocked write fails, and the thread comes to its end
  publisher.stop();

  EXPECT_EQ(refused, 50);
  const PoolFigures pool = publisher.pools()[1];
  EXPECT_EQ(pool.name, "publisher/corrections");
  EXPECT_EQ(pool.refused, refused);
  EXPECT_EQ(pool.high_water, pool.capacity);
}

// They come from a log of the bus; nobody takes them.
TEST_F(PublisherTest, MoreCommandsThanMayWaitAreRefused) {
  constexpr int kSent = 20;
  lcm_eventlog_t* log = lcm_eventlog_create(path_.c_str(), "w");
  ASSERT_NE(log, nullptr);
  std::string channel = "R2_LOOPSIFT_COMMAND";
  for (int number = 1; number <= kSent; ++number) {
    command_t command{};
    command.utime = std::chrono::duration_cast<std::chrono::microseconds>(
                        std::chrono::system_clock::now().time_since_epoch())
                        .count();
    command.sender = 7;
    command.number = number;
    command.command = command_t::PAUSE;
    std::vector<char> bytes(static_cast<std::size_t>(command.getEncodedSize()));
    command.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    lcm_eventlog_event_t event{};
    event.timestamp = number;
    event.channellen = static_cast<int>(channel.size());
    event.datalen = static_cast<int>(bytes.size());
    event.channel = channel.data();
    event.data = bytes.data();
    ASSERT_EQ(lcm_eventlog_write_event(log, &event), 0);
  }
  lcm_eventlog_destroy(log);
  settings_.url = "file://" + path_ + "?mode=r";
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  ASSERT_TRUE(publisher.start().ok());
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (publisher.commands_obeyed() + publisher.commands_refused() < kSent &&
         std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(publisher.commands_obeyed(), 16);
  EXPECT_EQ(publisher.commands_refused(), kSent - 16);
  Command command;
  int taken = 0;
  while (publisher.take(&command)) {
    EXPECT_EQ(command.kind, CommandKind::kPause);
    ++taken;
  }
  EXPECT_EQ(taken, 16) << "the first ones";
  publisher.stop();
}

TEST_F(PublisherTest, WithoutLcmItSaysWhatToDoAndStaysSilent) {
  settings_.url = "nosuchprovider://";
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  const Status started = publisher.start();
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().message, ::testing::HasSubstr("nosuchprovider://"));
  EXPECT_THAT(started.error().message, ::testing::HasSubstr("ip route add 224.0.0.0/4"));
  EXPECT_FALSE(publisher.running());
  EXPECT_FALSE(publisher.publish(PoseRecord{}));
  publisher.stop();
}

TEST_F(PublisherTest, DisabledItOpensNothing) {
  settings_.enabled = false;
  Arena arena(bytes_);
  Publisher publisher(settings_, arena);
  EXPECT_TRUE(publisher.start().ok());
  EXPECT_FALSE(publisher.publish(PoseRecord{}));
  EXPECT_NE(access(path_.c_str(), F_OK), 0);
}

}  // namespace
}  // namespace loopsift
