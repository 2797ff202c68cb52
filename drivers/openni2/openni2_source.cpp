// SPDX-License-Identifier: MIT
#include "drivers/openni2/openni2_source.hpp"

#include <algorithm>
#include <cassert>
#include <cinttypes>
#include <cstdio>
#include <optional>
#include <utility>

#include "core/base/heap_watch.hpp"
#include "core/base/steady_time.hpp"
#include "drivers/device_clock.hpp"
#include "drivers/openni2/camera.hpp"
#include "drivers/openni2/frame_copy.hpp"
#include "drivers/openni2/modes.hpp"
#include "drivers/openni2/pairing.hpp"

namespace loopsift {
namespace {

using openni2::Camera;
using openni2::PairStep;

constexpr std::int64_t kMillisecond = 1'000'000;
// A recording that has been silent for so long gives no more; for the second, where OpenNI2 says it is over.
constexpr std::int64_t kSilentNs = 5000 * kMillisecond, kSilentAtEndNs = 1000 * kMillisecond;

std::int64_t device_us(const openni::VideoFrameRef& frame) {
  return static_cast<std::int64_t>(frame.getTimestamp());
}

class OpenNi2Source final : public FrameSource {
 public:
  OpenNi2Source(std::unique_ptr<Camera> camera, bool host_time)
      : camera_(std::move(camera)),
        maps_time_(host_time && !camera_->is_recording()),
        half_frame_us_(static_cast<std::int64_t>(0.5e6 / camera_->info().nominal_rate_hz)) {
    message_.reserve(512);
  }

  [[nodiscard]] const SourceInfo& info() const override { return camera_->info(); }
  [[nodiscard]] const std::string& message() const override { return message_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;

 private:
  [[nodiscard]] std::optional<PairStep> next_step() const;
  [[nodiscard]] ReadStatus take_image(std::int64_t deadline_ns);
  [[nodiscard]] ReadStatus nothing_came();
  void keep(int stream, openni::VideoFrameRef* image);
  void drop_color();
  void drop_depth();
  [[nodiscard]] bool is_complete() const;
  [[nodiscard]] ReadStatus deliver(bool with_color, RawFrame* frame);
  [[nodiscard]] bool stamp(RawFrame* frame);
  template <class... Values>
  void say(const char* format, Values... values);

  const std::unique_ptr<Camera> camera_;
  const bool maps_time_;
  const std::int64_t half_frame_us_;
  DeviceClock clock_;
  std::optional<std::int64_t> last_timestamp_ns_;  // without maps_time_
  openni::VideoFrameRef depth_, next_depth_, color_;
  std::int64_t arrived_ns_ = 0, next_arrived_ns_ = 0;  // of depth_ and next_depth_
  int last_depth_index_ = 0, last_color_index_ = 0;
  std::int64_t silent_since_ns_ = 0;
  std::string message_;
};

template <class... Values>
void OpenNi2Source::say(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  message_ = text;
}

ReadStatus OpenNi2Source::read(RawFrame& frame, int timeout_ms) {
  message_.clear();
  const std::int64_t deadline_ns = steady_now_ns() + timeout_ms * kMillisecond;
  for (;;) {
    switch (next_step().value_or(PairStep::kWait)) {
      case PairStep::kPair:
        return deliver(true, &frame);
      case PairStep::kAlone:
        return deliver(false, &frame);
      case PairStep::kDropColor:
        drop_color();
        continue;
      case PairStep::kWait:
        break;
    }
    const ReadStatus status = take_image(deadline_ns);
    if (status != ReadStatus::kFrame) return status;
  }
}

// What to do with the depth image that waits; nothing where none does.
std::optional<PairStep> OpenNi2Source::next_step() const {
  if (!depth_.isValid()) return std::nullopt;
  if (!camera_->has_color() || is_complete()) {
    if (!color_.isValid()) return PairStep::kAlone;
  }
  std::optional<std::int64_t> color_us;
  if (color_.isValid()) color_us = device_us(color_);
  return openni2::pair_step(device_us(depth_), color_us, next_depth_.isValid(), half_frame_us_);
}

// Whether all images of a recording are here.
bool OpenNi2Source::is_complete() const {
  return camera_->is_recording() && last_depth_index_ >= camera_->depth().frames &&
         last_color_index_ >= camera_->color().frames;
}

// Waits for one more image of either stream. OpenNI2 takes memory for each image that it hands out or gets
// back, and has no way around it.
ReadStatus OpenNi2Source::take_image(std::int64_t deadline_ns) {
  if (is_complete()) return ReadStatus::kEnd;
  openni::VideoStream* streams[] = {&camera_->depth().video, &camera_->color().video};
  const int count = camera_->has_color() ? 2 : 1;
  const auto wait_ms = static_cast<int>(
      std::max<std::int64_t>(0, (deadline_ns - steady_now_ns() + kMillisecond - 1) / kMillisecond));
  int ready = -1;
  const HeapPardon openni2_only;
  const openni::Status status = openni::OpenNI::waitForAnyStream(streams, count, &ready, wait_ms);
  if (status == openni::STATUS_TIME_OUT) return nothing_came();
  openni::VideoFrameRef image;
  if (status != openni::STATUS_OK || streams[ready]->readFrame(&image) != openni::STATUS_OK ||
      !image.isValid()) {
    say("the device fails: %s", openni::OpenNI::getExtendedError());
    return ReadStatus::kLost;
  }
  keep(ready, &image);
  return ReadStatus::kFrame;
}

ReadStatus OpenNi2Source::nothing_came() {
  if (camera_->watch().is_gone() || camera_->watch().has_failed()) {
    say("%s", camera_->watch().is_gone() ? "the device was unplugged" : "the device reports an error");
    return ReadStatus::kLost;
  }
  if (!camera_->is_recording()) return ReadStatus::kTimeout;
  const std::int64_t now_ns = steady_now_ns();
  if (silent_since_ns_ == 0) silent_since_ns_ = now_ns;
  const std::int64_t limit_ns = camera_->watch().is_over() ? kSilentAtEndNs : kSilentNs;
  if (now_ns - silent_since_ns_ < limit_ns) return ReadStatus::kTimeout;
  say("the recording is damaged: it gives nothing after depth image %d of %d", last_depth_index_,
      camera_->depth().frames);
  return ReadStatus::kLost;
}

void OpenNi2Source::keep(int stream, openni::VideoFrameRef* image) {
  silent_since_ns_ = 0;
  if (stream == 1) {
    last_color_index_ = image->getFrameIndex();
    color_ = *image;
  } else if (!depth_.isValid()) {
    last_depth_index_ = image->getFrameIndex();
    depth_ = *image;
    arrived_ns_ = steady_now_ns();
  } else {
    last_depth_index_ = image->getFrameIndex();
    next_depth_ = *image;
    next_arrived_ns_ = steady_now_ns();
  }
}

void OpenNi2Source::drop_color() {
  const HeapPardon openni2_only;
  color_.release();
}

// The next one takes its place.
void OpenNi2Source::drop_depth() {
  const HeapPardon openni2_only;
  depth_ = next_depth_;
  arrived_ns_ = next_arrived_ns_;
  next_depth_.release();
}

ReadStatus OpenNi2Source::deliver(bool with_color, RawFrame* frame) {
  const SourceInfo& info = camera_->info();
  frame->sequence = depth_.getFrameIndex();
  frame->captured_ns = arrived_ns_;
  frame->depth = ImageView(frame->depth_buffer.data(), info.camera.width, info.camera.height);
  frame->color = {};
  assert(frame->depth_buffer.size() >= frame->depth.size());
  const bool in_time = stamp(frame);
  const bool whole = in_time && openni2::copy_depth(depth_, camera_->depth().mirrored, frame->depth);
  if (in_time && !whole) {
    say("depth image %d is %dx%d, not %dx%d", depth_.getFrameIndex(), depth_.getWidth(), depth_.getHeight(),
        info.camera.width, info.camera.height);
  }
  if (whole && with_color) {
    const ImageView<Rgb8> color(frame->color_buffer.data(), info.color_width, info.color_height);
    assert(frame->color_buffer.size() >= color.size());
    if (openni2::copy_color(color_, camera_->color().mirrored, color)) frame->color = color;
  }
  if (whole && camera_->has_color() && frame->color.empty()) {
    say("depth image %d has no colour image within half a frame of it", depth_.getFrameIndex());
  }
  if (with_color) drop_color();
  drop_depth();
  return whole ? ReadStatus::kFrame : ReadStatus::kBad;
}

// False when the device's time does not go on.
bool OpenNi2Source::stamp(RawFrame* frame) {
  const std::int64_t device_ns = 1000 * device_us(depth_);
  bool goes_on = !last_timestamp_ns_ || device_ns > *last_timestamp_ns_;
  frame->timestamp_ns = device_ns;
  if (maps_time_) goes_on = clock_.map(device_ns, arrived_ns_, &frame->timestamp_ns);
  if (!goes_on) {
    say("depth image %d: its time stamp, %" PRId64 " us, is not after the one before", depth_.getFrameIndex(),
        device_us(depth_));
  } else {
    last_timestamp_ns_ = frame->timestamp_ns;
  }
  return goes_on;
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_openni2(const std::string& address,
                                                    const SourceOptions& options) {
  auto camera = Camera::open(address, options);
  if (!camera) return camera.error();
  return std::unique_ptr<FrameSource>(
      std::make_unique<OpenNi2Source>(std::move(*camera), options.openni2.host_time));
}

}  // namespace loopsift
