// SPDX-License-Identifier: MIT
#include "drivers/decode_ahead.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr int kWidth = 8, kHeight = 4;
constexpr int kLongMs = 20000;  // far longer than any of these tests takes

// Gives out a script of results; each frame's pixels hold its number.
class ScriptedSource final : public FrameSource {
 public:
  explicit ScriptedSource(std::vector<ReadStatus> script, std::int64_t period_ns = 0)
      : script_(std::move(script)), period_ns_(period_ns) {
    info_.camera = {kWidth, kHeight, 10, 10, 4, 2};
    info_.color_width = kWidth;
    info_.color_height = kHeight;
  }
  SourceInfo info_;
  std::atomic<int> reads{0};
  std::string frame_message;
  bool silent = false;  // a device that says nothing
  int step = 1;         // of the frames' numbers

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] const std::string& message() const override { return message_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int /*timeout_ms*/) override {
    const int k = reads++;
    if (silent) return ReadStatus::kTimeout;
    if (static_cast<std::size_t>(k) >= script_.size()) return ReadStatus::kEnd;
    const ReadStatus status = script_[static_cast<std::size_t>(k)];
    message_ = status == ReadStatus::kFrame ? frame_message : "read " + std::to_string(k);
    if (status != ReadStatus::kFrame) return status;
    frame.sequence = std::int64_t{k} * step;
    frame.timestamp_ns = 5'000'000'000 + k * period_ns_;
    frame.depth = ImageView(frame.depth_buffer.data(), kWidth, kHeight);
    frame.color = ImageView(frame.color_buffer.data(), kWidth, kHeight);
    for (std::uint16_t& value : frame.depth_buffer) value = static_cast<std::uint16_t>(k);
    for (Rgb8& value : frame.color_buffer) value.g = static_cast<unsigned char>(k);
    return status;
  }

 private:
  std::vector<ReadStatus> script_;
  std::int64_t period_ns_;
  std::string message_;
};

std::vector<ReadStatus> frames(std::size_t n) { return std::vector<ReadStatus>(n, ReadStatus::kFrame); }

// A queue in an arena of exactly the size that measuring gave.
struct Rig {
  Rig(FrameSource& source, const FrameQueueOptions& options) {
    Arena measuring;
    { const FrameQueue measured(source, options, measuring); }
    arena = std::make_unique<Arena>(measuring.used_bytes());
    queue = std::make_unique<FrameQueue>(source, options, *arena);
  }
  std::unique_ptr<Arena> arena;
  std::unique_ptr<FrameQueue> queue;
};

// The producer is left alone until it has made `count` reads.
void wait_for_reads(const ScriptedSource& source, int count) {
  Semaphore never;
  while (source.reads < count) (void)never.wait_until(steady_now_ns() + 1'000'000);
}

void expect_intact(const RawFrame& frame) {
  for (std::size_t i = 0; i < frame.depth.size(); ++i) ASSERT_EQ(frame.depth.data[i], frame.sequence % 65536);
  for (std::size_t i = 0; i < frame.color.size(); ++i) ASSERT_EQ(frame.color.data[i].g, frame.sequence % 256);
}

TEST(FrameQueue, CarvesExactlyWhatItMeasured) {
  ScriptedSource source(frames(1));
  const Rig rig(source, {3, false});
  EXPECT_EQ(rig.arena->used_bytes(), rig.arena->capacity_bytes());
}

TEST(FrameQueue, AtMaxRateEveryFrameComesInOrderHoweverSlowTheReader) {
  ScriptedSource source(frames(500));
  const Rig rig(source, {2, false});
  rig.queue->start();
  RawFrame* frame = nullptr;
  for (int k = 0; k < 500; ++k) {
    ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
    if (k == 0) wait_for_reads(source, 4);  // as far ahead as it gets: capacity + 2 buffers, one of them ours
    EXPECT_LE(source.reads, k + 4);
    ASSERT_EQ(frame->sequence, k);
    expect_intact(*frame);
    EXPECT_GT(frame->captured_ns, 0);
    rig.queue->release(frame);
  }
  EXPECT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kEnd);
  EXPECT_EQ(rig.queue->next(&frame, 0), ReadStatus::kEnd) << "the end stays";
  EXPECT_EQ(frame, nullptr);
  EXPECT_EQ(rig.queue->counts().received, 500);
  EXPECT_EQ(rig.queue->counts().dropped, 0);
}

TEST(FrameQueue, InRealtimeASlowReaderGetsTheNewestAndTheRestIsCounted) {
  ScriptedSource source(frames(50));  // all due at once
  const Rig rig(source, {3, true});
  rig.queue->start();
  wait_for_reads(source, 51);
  RawFrame* frame = nullptr;
  for (int k = 47; k < 50; ++k) {
    ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
    EXPECT_EQ(frame->sequence, k);
    expect_intact(*frame);
    rig.queue->release(frame);
  }
  EXPECT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kEnd);
  EXPECT_EQ(rig.queue->counts().received, 50);
  EXPECT_EQ(rig.queue->counts().dropped, 47);
}

TEST(FrameQueue, InRealtimeAFrameInTheReadersHandsIsNeverOverwritten) {
  ScriptedSource source(frames(20000));
  const Rig rig(source, {1, true});
  rig.queue->start();
  RawFrame* frame = nullptr;
  std::int64_t seen = 0, last = -1;
  ReadStatus status;
  while ((status = rig.queue->next(&frame, kLongMs)) == ReadStatus::kFrame) {
    ASSERT_GT(frame->sequence, last);
    last = frame->sequence;
    expect_intact(*frame);
    rig.queue->release(frame);
    ++seen;
  }
  EXPECT_EQ(status, ReadStatus::kEnd);
  EXPECT_EQ(last, 19999) << "the newest frame is never the one that is dropped";
  EXPECT_EQ(seen + rig.queue->counts().dropped, 20000);
}

TEST(FrameQueue, InRealtimeFramesAreNotReleasedBeforeTheirTime) {
  constexpr std::int64_t kPeriodNs = 20'000'000;
  ScriptedSource source(frames(4), kPeriodNs);
  const Rig rig(source, {4, true});
  const std::int64_t started_ns = steady_now_ns();  // before the first release
  rig.queue->start();
  RawFrame* frame = nullptr;
  for (int k = 0; k < 4; ++k) {
    ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
    // Early would be a fault, late is the machine's business.
    EXPECT_GE(frame->captured_ns, started_ns + k * kPeriodNs);
    rig.queue->release(frame);
  }
}

TEST(FrameQueue, BadFramesAreReportedInTheirPlaceAndCounted) {
  ScriptedSource source({ReadStatus::kFrame, ReadStatus::kBad, ReadStatus::kTimeout, ReadStatus::kFrame});
  const Rig rig(source, {2, false});
  rig.queue->start();
  RawFrame* frame = nullptr;
  ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
  EXPECT_STREQ(rig.queue->message(), "");
  rig.queue->release(frame);
  EXPECT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kBad);
  EXPECT_STREQ(rig.queue->message(), "read 1");
  EXPECT_EQ(frame, nullptr);
  ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
  EXPECT_EQ(frame->sequence, 3);
  rig.queue->release(frame);
  EXPECT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kEnd);
  EXPECT_EQ(rig.queue->counts().bad, 1);
  EXPECT_EQ(rig.queue->counts().received, 2);
}

TEST(FrameQueue, FramesThatALiveDeviceLostAreCountedAsDropped) {
  std::vector<ReadStatus> script = frames(4);
  script[2] = ReadStatus::kBad;  // it came: of its number and the next one, one is lost
  for (const bool live : {true, false}) {
    ScriptedSource source(script);
    source.info_.live = live;
    source.step = 2;
    FrameQueueOptions options;
    options.capacity = 8;
    const Rig rig(source, options);
    rig.queue->start();
    RawFrame* frame = nullptr;
    ReadStatus status = ReadStatus::kFrame;
    while ((status = rig.queue->next(&frame, kLongMs)) != ReadStatus::kEnd) {
      ASSERT_NE(status, ReadStatus::kTimeout);
      if (frame != nullptr) rig.queue->release(frame);
    }
    EXPECT_EQ(rig.queue->counts().dropped, live ? 3 : 0);  // numbers 0, 2, bad, 6
  }
}

TEST(FrameQueue, AFrameWithoutItsColorComesWithTheReason) {
  ScriptedSource source(frames(1));
  source.frame_message = "a.jpg: truncated";
  const Rig rig(source, {2, false});
  rig.queue->start();
  RawFrame* frame = nullptr;
  ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
  EXPECT_STREQ(rig.queue->message(), "a.jpg: truncated");
  EXPECT_EQ(rig.queue->counts().without_color, 1);
  rig.queue->release(frame);
}

TEST(FrameQueue, ALostSourceIsToldAfterItsLastFrame) {
  ScriptedSource source({ReadStatus::kFrame, ReadStatus::kLost});
  const Rig rig(source, {2, false});
  rig.queue->start();
  RawFrame* frame = nullptr;
  ASSERT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kFrame);
  rig.queue->release(frame);
  EXPECT_EQ(rig.queue->next(&frame, kLongMs), ReadStatus::kLost);
  EXPECT_STREQ(rig.queue->message(), "read 1");
  EXPECT_EQ(rig.queue->next(&frame, 0), ReadStatus::kLost);
}

TEST(FrameQueue, ASilentSourceTimesOutAndStops) {
  ScriptedSource source({});
  source.silent = true;
  const Rig rig(source, {2, false});
  rig.queue->start();
  RawFrame* frame = nullptr;
  EXPECT_EQ(rig.queue->next(&frame, 5), ReadStatus::kTimeout);
  rig.queue->stop();
  EXPECT_EQ(rig.queue->next(&frame, 0), ReadStatus::kEnd);
}

TEST(FrameQueue, StopEndsAThreadThatWaitsForTheReaderOrForATimeStamp) {
  constexpr std::int64_t kHourNs = 3'600'000'000'000;
  for (const bool realtime : {false, true}) {
    ScriptedSource source(frames(100), kHourNs);
    const Rig rig(source, {1, realtime});
    rig.queue->start();
    wait_for_reads(source, 2);
    rig.queue->stop();
    EXPECT_LT(source.reads, 100);
  }
}

}  // namespace
}  // namespace loopsift
