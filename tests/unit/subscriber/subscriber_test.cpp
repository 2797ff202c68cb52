// SPDX-License-Identifier: MIT
// The subscriber on a bus within the process (memq://), fed with messages made by hand.
#include "loopsift/client/subscriber.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <thread>

#include "tests/unit/subscriber/messages.hpp"

namespace loopsift::client {
namespace {

using test::correction_message;
using test::fragment_message;
using test::graph_message;
using test::health_message;
using test::kRun;
using test::loop_message;
using test::pose_message;

class SubscriberTest : public ::testing::Test {
 protected:
  template <class Message>
  void send(const char* channel, const Message& message) {
    ASSERT_EQ(lcm_.publish(channel, &message), 0);
    handle();
  }
  void send_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
    ASSERT_EQ(lcm_.publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size())), 0);
    handle();
  }
  void handle() {
    while (lcm_.handleTimeout(0) > 0) {
    }
  }
  void send_a_whole_state() {
    send("LOOPSIFT_HEALTH", health_message(1, 1));
    send("LOOPSIFT_POSE", pose_message(1000, 0.5, 1));
    send("LOOPSIFT_CORRECTION", correction_message(1));
    send("LOOPSIFT_LOOP", loop_message(4));
    send("LOOPSIFT_GRAPH", graph_message(1, 1, 3, 0));
    send("LOOPSIFT_FRAGMENT", fragment_message(0, 3, 0));
  }
  lcm::LCM lcm_{"memq://"};
  Subscriber subscriber_{lcm_};
};

/// What the program would hear.
class CommandLog {
 public:
  explicit CommandLog(lcm::LCM& lcm) {
    lcm.subscribeFunction("LOOPSIFT_COMMAND", &CommandLog::receive, this);
  }
  std::vector<command_t> commands;

 private:
  static void receive(const lcm::ReceiveBuffer* /*buffer*/, const std::string& /*channel*/,
                      const command_t* m, CommandLog* self) {
    self->commands.push_back(*m);
  }
};

TEST_F(SubscriberTest, KnowsThePoseNowAndAtATime) {
  EXPECT_FALSE(subscriber_.pose());
  EXPECT_FALSE(subscriber_.pose_at(0));
  send("LOOPSIFT_POSE", pose_message(1000, 1));
  send("LOOPSIFT_POSE", pose_message(2000, 3));
  ASSERT_TRUE(subscriber_.pose());
  EXPECT_EQ(subscriber_.pose()->utime, 2000);
  EXPECT_EQ(subscriber_.pose()->covariance[0], 1e-4);
  ASSERT_TRUE(subscriber_.pose_at(1250));
  EXPECT_NEAR(subscriber_.pose_at(1250)->T_map_body.trans[0], 1.5, 1e-12);
  EXPECT_NEAR(subscriber_.pose_at(1000)->T_map_body.trans[0], 1, 1e-12);
  EXPECT_FALSE(subscriber_.pose_at(999));
  EXPECT_FALSE(subscriber_.pose_at(2001));
  send("LOOPSIFT_CORRECTION", correction_message(1));
  EXPECT_NEAR(subscriber_.pose_at(1250)->T_map_body.trans[1], 1, 1e-12) << "old poses move with the map";
  send("LOOPSIFT_POSE", pose_message(3000, 3, 2));
  EXPECT_NEAR(subscriber_.T_map_odom().trans[1], 2, 1e-12) << "a lost correction shows in the pose";
}

TEST_F(SubscriberTest, SaysThatAPoseInTheMapIsNotKnownAfterALoss) {
  send("LOOPSIFT_POSE", pose_message(1000, 1));
  EXPECT_TRUE(subscriber_.pose()->anchored);
  pose_t lost = pose_message(2000, 1);
  lost.anchored = 0;
  lost.piece = 60;
  send("LOOPSIFT_POSE", lost);
  EXPECT_FALSE(subscriber_.pose()->anchored);
  EXPECT_EQ(subscriber_.pose()->piece, 60);
}

TEST_F(SubscriberTest, ForgetsPosesOlderThanItsHistory) {
  SubscriberOptions options;
  options.history_s = 1;
  Subscriber brief(lcm_, options);
  for (std::int64_t t = 1; t <= 30; ++t) send("LOOPSIFT_POSE", pose_message(t * 100'000, 0));
  EXPECT_FALSE(brief.pose_at(1'900'000));
  EXPECT_TRUE(brief.pose_at(2'000'000));
}

TEST_F(SubscriberTest, IsCompleteOnceAllIsHere) {
  EXPECT_FALSE(subscriber_.complete());
  send_a_whole_state();
  EXPECT_TRUE(subscriber_.complete());
  EXPECT_EQ(subscriber_.corrections().size(), 1U);
  EXPECT_EQ(subscriber_.loops().at(4).reason, "because");
  EXPECT_EQ(subscriber_.refused(), 0);
  health_t health = health_message(2, 2);
  health.epoch = 2;
  send("LOOPSIFT_HEALTH", health);
  EXPECT_FALSE(subscriber_.complete()) << "health tells that there is more";
}

TEST_F(SubscriberTest, AsksForWhatIsMissingAndNotMore) {
  CommandLog program(lcm_);
  subscriber_.poll();
  handle();
  ASSERT_EQ(program.commands.size(), 1U);
  EXPECT_EQ(program.commands[0].command, command_t::RESEND);
  EXPECT_EQ(program.commands[0].n_objects, 3);  // state, loops, graph
  subscriber_.poll();
  handle();
  EXPECT_EQ(program.commands.size(), 1U) << "not at once again";
  send_a_whole_state();
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  subscriber_.poll();
  handle();
  EXPECT_EQ(program.commands.size(), 1U);
}

TEST_F(SubscriberTest, CommandsAreNumberedAndTheirAnswersFound) {
  CommandLog program(lcm_);
  send("LOOPSIFT_HEALTH", health_message(1));
  const std::int32_t first = subscriber_.send(command_t::PAUSE);
  const std::int32_t second = subscriber_.send(command_t::SAVE);
  handle();
  ASSERT_EQ(program.commands.size(), 2U);
  EXPECT_EQ(second, first + 1);
  EXPECT_EQ(program.commands[1].run, kRun);
  ack_t ack{};
  ack.run = kRun;
  ack.sender = program.commands[0].sender;
  ack.number = second;
  ack.status = ack_t::DONE;
  send("LOOPSIFT_ACK", ack);
  EXPECT_TRUE(subscriber_.answer(second));
  EXPECT_FALSE(subscriber_.answer(first));
  ack.sender ^= 1;
  ack.number = first;
  send("LOOPSIFT_ACK", ack);
  EXPECT_FALSE(subscriber_.answer(first)) << "another sender's";
}

TEST_F(SubscriberTest, ANewRunStartsAfreshAndAnOldOneIsOutOfDate) {
  send_a_whole_state();
  pose_t pose = pose_message(10, 7);
  pose.run = kRun - 1;
  send("LOOPSIFT_POSE", pose);
  EXPECT_EQ(subscriber_.refused(), 1);
  EXPECT_TRUE(subscriber_.complete());
  pose.run = kRun + 1;
  send("LOOPSIFT_POSE", pose);
  EXPECT_EQ(subscriber_.runs_seen(), 2);
  EXPECT_EQ(subscriber_.pose()->utime, 10);
  EXPECT_FALSE(subscriber_.complete());
  EXPECT_TRUE(subscriber_.corrections().empty());
}

TEST_F(SubscriberTest, AnotherPrefixIsAnotherProgram) {
  SubscriberOptions options;
  options.prefix = "R2_";
  Subscriber other(lcm_, options);
  send("R2_LOOPSIFT_POSE", pose_message(5, 1));
  EXPECT_TRUE(other.pose());
  EXPECT_FALSE(subscriber_.pose());
}

template <class Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// Random bytes, cut and lengthened messages, wrong fingerprints, NaN, texts of negative length, old times.
TEST_F(SubscriberTest, TenThousandMalformedMessagesChangeNothing) {
  send_a_whole_state();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  pose_t pose = pose_message(2000, 1, 1);
  pose.T_map_body.quat[2] = nan;
  correction_t correction = correction_message(2);
  correction.T_map_odom.trans[1] = nan;
  loop_t loop = loop_message(4);
  loop.T_i_j.quat[0] = 7;
  health_t health = health_message(0.5, 1);  // older than what is known
  fragment_t fragment = fragment_message(0, 3, 0);
  fragment.z[1] = std::numeric_limits<float>::infinity();
  graph_t graph = graph_message(2, 1, 3, 0);
  graph.fragments[0].R[4] = nan;
  const std::vector<std::pair<const char*, std::vector<std::uint8_t>>> kinds = {
      {"LOOPSIFT_POSE", encoded(pose)},         {"LOOPSIFT_CORRECTION", encoded(correction)},
      {"LOOPSIFT_LOOP", encoded(loop)},         {"LOOPSIFT_HEALTH", encoded(health)},
      {"LOOPSIFT_FRAGMENT", encoded(fragment)}, {"LOOPSIFT_GRAPH", encoded(graph)}};
  std::mt19937 random(5);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  constexpr int kMessages = 10'000;
  for (int i = 0; i < kMessages; ++i) {
    const auto& [channel, nonsense] = kinds[below(kinds.size())];
    std::vector<std::uint8_t> bytes = nonsense;
    switch (i % 4) {
      case 0:
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
        break;
      case 1:
        bytes.resize(below(2 * nonsense.size()));
        if (bytes.size() == nonsense.size()) bytes.pop_back();
        break;
      case 2:
        bytes[below(8)] ^= static_cast<std::uint8_t>(1 + below(255));
        break;
      case 3:  // as it is, or its text's length made negative
        if (std::string(channel) == "LOOPSIFT_LOOP" && below(2) == 0) bytes[bytes.size() - 4 - 8 - 4] = 0xFF;
        break;
    }
    send_bytes(channel, bytes);
  }
  EXPECT_EQ(subscriber_.refused(), kMessages);
  EXPECT_TRUE(subscriber_.complete());
  EXPECT_EQ(subscriber_.runs_seen(), 1);
  EXPECT_EQ(subscriber_.pose()->utime, 1000);
  EXPECT_EQ(subscriber_.corrections().size(), 1U);
  EXPECT_EQ(subscriber_.loops().size(), 1U);
  EXPECT_EQ(subscriber_.loops().at(4).T_i_j.quat[0], 1);
  EXPECT_EQ(subscriber_.map().graph().version, 1);
  EXPECT_EQ(subscriber_.health()->uptime_s, 1);
}

}  // namespace
}  // namespace loopsift::client
