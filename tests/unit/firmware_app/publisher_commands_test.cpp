// SPDX-License-Identifier: MIT
// What comes in over LCM is trusted with nothing.
#include "firmware_app/publisher_commands.hpp"

#include <gmock/gmock.h>

#include <loopsift/command_t.hpp>
#include <random>
#include <vector>

namespace loopsift {
namespace {

using Verdict = CheckedCommand::Verdict;
constexpr std::int64_t kRun = 1'700'000'000'000'000;
constexpr std::int64_t kNow = kRun + 60'000'000;
constexpr std::int32_t kFragments = 12;

command_t valid(std::int32_t number, std::int8_t command = command_t::PAUSE) {
  command_t message{};
  message.utime = kNow - 1000;
  message.run = kRun;
  message.sender = 77;
  message.number = number;
  message.command = command;
  return message;
}

command_t resend(std::int32_t number) {
  command_t message = valid(number, command_t::RESEND);
  message.n_objects = 2;
  message.object[0] = 3;
  message.first_chunk[0] = 256;
  message.chunks[0][0] = 0b101;
  message.chunks[0][31] = 0x80;
  message.object[1] = command_t::STATE;
  return message;
}

std::vector<std::uint8_t> encoded(const command_t& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

class CommandGateTest : public ::testing::Test {
 protected:
  CheckedCommand check(const command_t& message) { return check(encoded(message)); }
  CheckedCommand check(const std::vector<std::uint8_t>& bytes) {
    return gate_.check(bytes.data(), bytes.size(), kNow, kFragments);
  }
  void expect_refused(const command_t& message, const char* reason) {
    const CheckedCommand checked = check(message);
    EXPECT_EQ(checked.verdict, Verdict::kRefuse) << reason;
    EXPECT_THAT(checked.reason, ::testing::HasSubstr(reason));
    EXPECT_EQ(checked.command.number, message.number) << "it can be answered";
  }
  CommandGate gate_{kRun, 10'000'000};
};

TEST_F(CommandGateTest, PassesWhatIsRightAndSaysWhatIsWanted) {
  const CheckedCommand pause = check(valid(1));
  EXPECT_EQ(pause.verdict, Verdict::kObey);
  EXPECT_EQ(pause.command.kind, CommandKind::kPause);
  EXPECT_EQ(pause.command.sender, 77);
  const CheckedCommand wanted = check(resend(2));
  ASSERT_EQ(wanted.verdict, Verdict::kObey);
  ASSERT_EQ(wanted.window_count, 2);
  EXPECT_EQ(wanted.windows[0].object, 3);
  EXPECT_EQ(wanted.windows[0].first, 256);
  EXPECT_THAT(wanted.windows[0].bits, ::testing::ElementsAre(5U, 0U, 0U, 1ULL << 63));
  EXPECT_EQ(wanted.windows[1].object, kStateObject);
}

TEST_F(CommandGateTest, ACommandIsObeyedOnce) {
  EXPECT_EQ(check(valid(5)).verdict, Verdict::kObey);
  EXPECT_EQ(check(valid(5)).verdict, Verdict::kRepeat);
  expect_refused(valid(4), "not above");
  command_t other = valid(1);
  other.sender = 78;
  EXPECT_EQ(check(other).verdict, Verdict::kObey) << "each sender counts for itself";
  EXPECT_EQ(check(valid(6)).verdict, Verdict::kObey);
}

TEST_F(CommandGateTest, RefusesWhatIsOutOfDateOrOutOfRange) {
  command_t message = valid(1);
  message.utime = kNow - 11'000'000;
  expect_refused(message, "too old");
  message.utime = INT64_MAX;
  expect_refused(message, "too old");
  message = valid(1);
  message.run = kRun - 1;
  expect_refused(message, "another run");
  message = valid(1);
  message.sender = 0;
  expect_refused(message, "sender");
  expect_refused(valid(0), "not above");
  expect_refused(valid(1, 0), "no such");
  expect_refused(valid(1, 6), "no such");
  message = valid(1);
  message.n_objects = 1;
  expect_refused(message, "only RESEND");
  for (const int count : {0, 33, -1, INT32_MIN}) {
    message = resend(1);
    message.n_objects = count;
    expect_refused(message, "1 to 32");
  }
  for (const int object : {kFragments, -4, INT32_MAX}) {
    message = resend(1);
    message.object[1] = object;
    expect_refused(message, "neither");
  }
  message = resend(1);
  message.first_chunk[0] = -1;
  expect_refused(message, "negative");
  EXPECT_EQ(check(valid(1)).verdict, Verdict::kObey) << "nothing that was refused counts";
}

TEST_F(CommandGateTest, IgnoresWhatCannotBeDecoded) {
  std::vector<std::uint8_t> bytes = encoded(valid(1));
  bytes.push_back(0);
  EXPECT_EQ(check(bytes).verdict, Verdict::kIgnore);
  bytes.resize(bytes.size() - 2);
  EXPECT_EQ(check(bytes).verdict, Verdict::kIgnore);
  EXPECT_EQ(check(std::vector<std::uint8_t>()).verdict, Verdict::kIgnore);
  EXPECT_EQ(check(std::vector<std::uint8_t>(1 << 20, 0xFF)).verdict, Verdict::kIgnore);
  bytes = encoded(valid(1));
  bytes[3] ^= 1;  // the type's fingerprint
  EXPECT_EQ(check(bytes).verdict, Verdict::kIgnore);
}

// Random bytes, cut and lengthened messages, and flipped bits in everything that a check looks at.
TEST_F(CommandGateTest, TenThousandMalformedMessagesChangeNothing) {
  std::mt19937 random(3);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  const std::vector<std::uint8_t> good = encoded(resend(1));
  constexpr std::size_t kChecked = 8 + 8 + 8 + 8 + 4 + 1 + 4;  // fingerprint to n_objects
  int obeyed = 0;
  for (int i = 0; i < 10'000; ++i) {
    std::vector<std::uint8_t> bytes = good;
    switch (i % 4) {
      case 0:
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
        break;
      case 1:
        bytes.resize(below(3 * good.size()));
        if (bytes.size() == good.size()) bytes.pop_back();
        break;
      case 2:
        bytes[below(8)] ^= static_cast<std::uint8_t>(1 + below(255));
        break;
      case 3:  // right in form: run, n_objects or an object is not
        bytes[16 + below(8)] ^= static_cast<std::uint8_t>(1 + below(255));
        if (below(2) == 0) bytes[kChecked - 4] = 0x80;
        break;
    }
    const Verdict verdict = check(bytes).verdict;
    if (verdict == Verdict::kObey || verdict == Verdict::kRepeat) ++obeyed;
  }
  EXPECT_EQ(obeyed, 0);
  EXPECT_EQ(check(good).verdict, Verdict::kObey);
}

TEST_F(CommandGateTest, ManySendersPushOutTheOneNotHeardForLongest) {
  for (std::int64_t sender = 1; sender <= 40; ++sender) {
    command_t message = valid(9);
    message.sender = sender;
    const std::vector<std::uint8_t> bytes = encoded(message);
    EXPECT_EQ(gate_.check(bytes.data(), bytes.size(), kNow + sender, kFragments).verdict, Verdict::kObey);
  }
  command_t again = valid(9);
  again.sender = 40;
  EXPECT_EQ(check(again).verdict, Verdict::kRepeat);
}

}  // namespace
}  // namespace loopsift
