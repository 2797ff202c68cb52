// SPDX-License-Identifier: MIT
// Reads and decodes a FrameSource on a thread of its own, ahead of the consumer.
// In: a source. Out: its frames in order, in buffers carved from the arena (capacity + 2 of them: one is
// being decoded, one is with the consumer). Threads: the capture thread runs the reading, one other thread
// calls next() and release(). Neither allocates past what the source's read() does.
//
// Policy. At rate `max` nothing is dropped and nothing depends on timing: each side waits for the other. In
// `realtime`, and from a live source, a frame that is due while `capacity` frames wait takes the place of the
// oldest, which is dropped and counted; a recording's frames are due at their time stamps, counted from the
// first.
#pragma once
#include <atomic>
#include <cstdint>
#include <thread>

#include "core/base/arena.hpp"
#include "core/base/drop_oldest_ring.hpp"
#include "core/base/semaphore.hpp"
#include "core/base/spsc_ring.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift {

struct FrameQueueOptions {
  int capacity = 4;       ///< frames that may wait; at least 1
  bool realtime = false;  ///< release a recording's frames at their time stamps
};

struct FrameQueueCounts {
  std::int64_t received = 0;  ///< frames read, those dropped later among them
  std::int64_t dropped = 0;   ///< frames that the consumer was too slow for, or a live device lost itself
  std::int64_t bad = 0;       ///< frames that could not be used
  std::int64_t without_color = 0;  ///< frames whose colour was broken
};

class FrameQueue {
 public:
  /// Carves the buffers. The source must outlive the queue.
  FrameQueue(FrameSource& source, const FrameQueueOptions& options, Arena& arena);
  ~FrameQueue() { stop(); }
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;

  /// Starts the capture thread. Once; set-up only.
  void start();
  /// The capture thread's body, for a caller that makes the thread itself instead of start(). Returns at the
  /// end of the source, when it is lost, or after stop().
  void run();

  /// The next frame, to be given back with release() before the next call. kBad: one frame was unusable
  /// (message() says why). kEnd and kLost are final and stay. kTimeout: nothing within timeout_ms.
  [[nodiscard]] ReadStatus next(RawFrame** frame, int timeout_ms);
  void release(RawFrame* frame);
  /// Why the last next() was kBad or kLost, or why its frame has no colour; empty otherwise. Consumer's
  /// thread.
  [[nodiscard]] const char* message() const { return message_; }

  /// Any thread.
  [[nodiscard]] FrameQueueCounts counts() const;
  /// Ends the capture thread and waits for it; next() comes to kEnd after the frames that still wait.
  /// Consumer's thread.
  void stop();

 private:
  static constexpr std::size_t kMessageBytes = 512;
  using Message = char[kMessageBytes];
  struct Slot {
    RawFrame frame;
    bool usable;  // false: kBad
    Message message;
  };

  void set_up_slots();
  [[nodiscard]] bool take_free(std::uint32_t* slot);
  [[nodiscard]] ReadStatus read_into(Slot* slot);
  void keep_message(Message& message) const;
  void count_gap(std::int64_t sequence);
  void wait_until_due(Slot* slot);
  void publish(std::uint32_t slot);
  void give_back(std::uint32_t slot);

  FrameSource& source_;
  const bool paced_;         // frames are released at their time stamps
  const bool drops_oldest_;  // the capture thread never waits for the consumer
  const std::size_t depth_pixels_, color_pixels_, slot_count_;
  Span<Slot> slots_;
  Span<std::uint16_t> depth_;
  Span<Rgb8> color_;

  DropOldestRing ready_;          // capture → consumer
  SpscRing<std::uint32_t> free_;  // consumer → capture
  Semaphore ready_or_stop_, free_or_stop_, stop_requested_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;

  // Set once by the capture thread, after its last frame.
  std::atomic<bool> over_{false};
  ReadStatus final_status_ = ReadStatus::kEnd;
  Message final_message_ = "";

  // Capture thread's.
  bool has_spare_ = false;
  std::uint32_t spare_ = 0;              // a dropped frame's slot, taken before the free ones
  std::int64_t expected_sequence_ = -1;  // of a live device's next frame; −1 before the first
  bool first_ = true;
  std::int64_t first_timestamp_ns_ = 0, first_release_ns_ = 0;

  Message message_ = "";  // consumer's

  std::atomic<std::int64_t> received_{0}, dropped_{0}, bad_{0}, without_color_{0};
};

}  // namespace loopsift
