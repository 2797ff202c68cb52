// SPDX-License-Identifier: MIT
#include "drivers/decode_ahead.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <new>
#include <type_traits>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr int kReadTimeoutMs = 100;  // how long a silent device may keep stop() waiting

std::size_t pixels(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

}  // namespace

FrameQueue::FrameQueue(FrameSource& source, const FrameQueueOptions& options, Arena& arena)
    : source_(source),
      paced_(options.realtime && !source.info().live),
      drops_oldest_(options.realtime || source.info().live),
      depth_pixels_(pixels(source.info().camera.width, source.info().camera.height)),
      color_pixels_(pixels(source.info().color_width, source.info().color_height)),
      slot_count_(static_cast<std::size_t>(std::max(1, options.capacity)) + 2),
      slots_(arena.carve<Slot>("capture/frames", slot_count_)),
      depth_(arena.carve<std::uint16_t>("capture/depth", slot_count_ * depth_pixels_)),
      color_(arena.carve<Rgb8>("capture/color", slot_count_ * color_pixels_)),
      ready_(
          arena.carve<DropOldestRing::Slot>("capture/ready", drops_oldest_ ? slot_count_ - 2 : slot_count_)),
      free_(arena.carve<std::uint32_t>("capture/free", slot_count_)) {}

void FrameQueue::set_up_slots() {
  for (std::size_t k = 0; k < slot_count_; ++k) {
    Slot* slot = new (&slots_[k]) Slot();
    slot->frame.depth_buffer = {depth_.data() + k * depth_pixels_, depth_pixels_};
    slot->frame.color_buffer = {color_.data() + k * color_pixels_, color_pixels_};
    give_back(static_cast<std::uint32_t>(k));
  }
}

void FrameQueue::start() {
  thread_ = std::thread([this] { run(); });
}

void FrameQueue::run() {
  set_up_slots();
  ReadStatus status = ReadStatus::kEnd;
  std::uint32_t index = 0;
  while (take_free(&index)) {
    Slot& slot = slots_[index];
    status = read_into(&slot);
    if (status != ReadStatus::kFrame && status != ReadStatus::kBad) break;
    if (slot.usable) wait_until_due(&slot);
    publish(index);
  }
  if (status == ReadStatus::kLost) {
    final_status_ = status;
    keep_message(final_message_);
  }
  over_.store(true, std::memory_order_release);
  ready_or_stop_.post();
}

// Fills the slot and counts it. kTimeout only after stop().
ReadStatus FrameQueue::read_into(Slot* slot) {
  ReadStatus status = ReadStatus::kTimeout;
  while (status == ReadStatus::kTimeout && !stopping_.load(std::memory_order_acquire)) {
    status = source_.read(slot->frame, kReadTimeoutMs);
  }
  slot->usable = status == ReadStatus::kFrame;
  keep_message(slot->message);
  if (status == ReadStatus::kBad) {
    bad_.fetch_add(1, std::memory_order_relaxed);
    if (expected_sequence_ >= 0) ++expected_sequence_;  // it came, even so
  }
  if (!slot->usable) return status;
  if (source_.info().live) count_gap(slot->frame.sequence);
  received_.fetch_add(1, std::memory_order_relaxed);
  if (slot->message[0] != '\0') without_color_.fetch_add(1, std::memory_order_relaxed);
  return status;
}

// Numbers that a live device passed over are frames that it lost before us. (A recording's are not dropped
// now: they are not in it.)
void FrameQueue::count_gap(std::int64_t sequence) {
  if (expected_sequence_ >= 0 && sequence > expected_sequence_)
    dropped_.fetch_add(sequence - expected_sequence_, std::memory_order_relaxed);
  expected_sequence_ = sequence + 1;
}

void FrameQueue::keep_message(Message& message) const {
  const std::string& why = source_.message();
  const std::size_t length = std::min(why.size(), kMessageBytes - 1);
  std::memcpy(message, why.data(), length);
  message[length] = '\0';
}

bool FrameQueue::take_free(std::uint32_t* slot) {
  if (has_spare_) {
    *slot = spare_;
    has_spare_ = false;
    return !stopping_.load(std::memory_order_acquire);
  }
  while (!stopping_.load(std::memory_order_acquire)) {
    if (free_.try_pop(slot)) return true;
    free_or_stop_.wait();
  }
  return false;
}

void FrameQueue::wait_until_due(Slot* slot) {
  if (source_.info().live) return;  // it came when it came
  if (paced_) {
    if (first_) {
      first_timestamp_ns_ = slot->frame.timestamp_ns;
      first_release_ns_ = steady_now_ns();
      first_ = false;
    }
    const std::int64_t due = first_release_ns_ + (slot->frame.timestamp_ns - first_timestamp_ns_);
    if (due > steady_now_ns())
      (void)stop_requested_.wait_until(due);  // false is the ordinary case: time has come
  }
  slot->frame.captured_ns = steady_now_ns();
}

void FrameQueue::publish(std::uint32_t slot) {
  while (!ready_.try_push(slot)) {
    assert(drops_oldest_ && "at rate max the ring holds every slot there is");
    has_spare_ = ready_.try_pop(&spare_);  // false when the consumer has just made room
    if (has_spare_ && slots_[spare_].usable) dropped_.fetch_add(1, std::memory_order_relaxed);
  }
  ready_or_stop_.post();
}

ReadStatus FrameQueue::next(RawFrame** frame, int timeout_ms) {
  *frame = nullptr;
  message_[0] = '\0';
  const std::int64_t deadline = steady_now_ns() + std::int64_t{timeout_ms} * 1'000'000;
  std::uint32_t index = 0;
  while (!ready_.try_pop(&index)) {
    // Over is said after the last frame was pushed: only an empty ring that is seen after it is the end.
    if (over_.load(std::memory_order_acquire)) {
      if (ready_.try_pop(&index)) break;
      std::memcpy(message_, final_message_, kMessageBytes);
      return final_status_;
    }
    if (!ready_or_stop_.wait_until(deadline)) return ReadStatus::kTimeout;
  }
  Slot& slot = slots_[index];
  std::memcpy(message_, slot.message, kMessageBytes);
  if (slot.usable) {
    *frame = &slot.frame;
    return ReadStatus::kFrame;
  }
  give_back(index);
  return ReadStatus::kBad;
}

void FrameQueue::release(RawFrame* frame) {
  static_assert(std::is_standard_layout_v<Slot>, "a pointer to a slot's first member is one to the slot");
  give_back(static_cast<std::uint32_t>(reinterpret_cast<Slot*>(frame) - slots_.data()));
}

void FrameQueue::give_back(std::uint32_t slot) {
  const bool pushed = free_.try_push(slot);
  assert(pushed && "a frame was released twice");
  (void)pushed;
  free_or_stop_.post();
}

FrameQueueCounts FrameQueue::counts() const {
  return {received_.load(std::memory_order_relaxed), dropped_.load(std::memory_order_relaxed),
          bad_.load(std::memory_order_relaxed), without_color_.load(std::memory_order_relaxed)};
}

void FrameQueue::stop() {
  stopping_.store(true, std::memory_order_release);
  free_or_stop_.post();
  stop_requested_.post();
  if (thread_.joinable()) thread_.join();
}

}  // namespace loopsift
