// SPDX-License-Identifier: MIT
#include "drivers/lcm/lcm_source.hpp"

#include <algorithm>
#include <utility>

#include "core/base/steady_time.hpp"
#include "drivers/lcm/lcm_clock.hpp"

namespace loopsift {
namespace {

constexpr int kHearTimeout_ms = 50;              // how long a silent bus may keep the end waiting
constexpr int kWaitingMessages = 8;              // in LCM, while one is decoded
constexpr std::int64_t kRestart_us = 1'000'000;  // time stamps that go back by so much are a new start
constexpr std::int64_t kMillisecond_ns = 1'000'000;

// What the first message says.
struct FirstMessage {
  bool heard = false;
  const char* problem = nullptr;
  ImagesMessage images;  // its views are void
};

void note_first(const lcm_recv_buf_t* received, const char* /*channel*/, void* first) {
  auto* note = static_cast<FirstMessage*>(first);
  if (note->heard && note->problem == nullptr) return;
  note->heard = true;
  note->problem =
      parse_images({static_cast<const std::uint8_t*>(received->data), received->data_size}, &note->images);
}

Expected<ImagesMessage> wait_for_first(lcm_t* lcm, const std::string& channel, const LcmInOptions& options) {
  FirstMessage first;
  lcm_subscription_t* subscription = lcm_subscribe(lcm, channel.c_str(), note_first, &first);
  const std::int64_t until = steady_now_ns() + static_cast<std::int64_t>(options.open_timeout_s * 1e9);
  while ((!first.heard || first.problem != nullptr) && steady_now_ns() < until) {
    const std::int64_t left_ms = (until - steady_now_ns()) / kMillisecond_ns + 1;
    if (lcm_handle_timeout(lcm, static_cast<int>(std::clamp<std::int64_t>(left_ms, 1, kHearTimeout_ms))) < 0)
      break;
  }
  lcm_unsubscribe(lcm, subscription);
  if (first.problem != nullptr) return Error{ErrorCode::kFormat, "lcm:" + channel + ": " + first.problem};
  if (!first.heard)
    return Error{ErrorCode::kNotFound,
                 "lcm:" + channel +
                     ": no message came within lcm_in.open_timeout_s; does its sender run, on " +
                     options.url + " (lcm_in.url)?"};
  return first.images;
}

SourceInfo describe(const std::string& channel, const ImagesMessage& first, const SourceOptions& options) {
  SourceInfo info;
  info.description = "lcm:" + channel;
  const PinholeCamera& given = options.camera;
  PinholeCamera& camera = info.camera;
  camera.width = first.depth.width;
  camera.height = first.depth.height;
  const float focal = 525.0F * static_cast<float>(camera.width) / 640.0F;
  camera.fx = given.fx > 0 ? given.fx : focal;
  camera.fy = given.fy > 0 ? given.fy : camera.fx;
  camera.cx = given.cx > 0 ? given.cx : static_cast<float>(camera.width - 1) / 2.0F;
  camera.cy = given.cy > 0 ? given.cy : static_cast<float>(camera.height - 1) / 2.0F;
  info.depth_unit_m = options.depth_scale > 0 ? 1.0 / options.depth_scale : 0.001;
  if (options.want_color && !first.color.data.empty()) {
    info.color_width = first.color.width;
    info.color_height = first.color.height;
  }
  info.nominal_rate_hz = options.lcm_in.rate_hz;
  info.live = true;
  return info;
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_lcm(const std::string& channel, const SourceOptions& options) {
  if (channel.empty()) return Error{ErrorCode::kUsage, "lcm: names no channel; write lcm:CHANNEL"};
  lcm_t* lcm = lcm_create(options.lcm_in.url.c_str());
  if (lcm == nullptr)
    return Error{ErrorCode::kIo, "lcm:" + channel + ": LCM cannot be opened at " + options.lcm_in.url +
                                     " (lcm_in.url); for udpm:// a multicast route is needed: ip link set lo "
                                     "multicast on; ip route add 224.0.0.0/4 dev lo"};
  return open_lcm(lcm, channel, options);
}

Expected<std::unique_ptr<FrameSource>> open_lcm(lcm_t* lcm, const std::string& channel,
                                                const SourceOptions& options) {
  const auto first = wait_for_first(lcm, channel, options.lcm_in);
  if (!first) {
    lcm_destroy(lcm);
    return first.error();
  }
  const std::int64_t offset_ns = options.lcm_in.host_clock ? wall_to_monotonic_ns() : 0;
  return std::unique_ptr<FrameSource>(
      std::make_unique<LcmSource>(lcm, channel, describe(channel, *first, options), offset_ns));
}

LcmSource::LcmSource(lcm_t* lcm, std::string channel, SourceInfo info, std::int64_t clock_offset_ns)
    : lcm_(lcm),
      channel_(std::move(channel)),
      info_(std::move(info)),
      clock_offset_ns_(clock_offset_ns),
      decoder_(std::max(1, info_.color_width), std::max(1, info_.color_height)) {
  message_.reserve(512);
  const auto handler = [](const lcm_recv_buf_t* received, const char* /*channel*/, void* self) {
    static_cast<LcmSource*>(self)->receive(*received);
  };
  lcm_subscription_t* subscription = lcm_subscribe(lcm_, channel_.c_str(), handler, this);
  lcm_subscription_set_queue_capacity(subscription, kWaitingMessages);
  thread_ = std::thread([this] { hear(); });
}

LcmSource::~LcmSource() {
  stopping_ = true;
  lent_or_stop_.post();
  thread_.join();
  lcm_destroy(lcm_);
}

ReadStatus LcmSource::read(RawFrame& frame, int timeout_ms) {
  message_.clear();
  lent_.store(&frame, std::memory_order_release);
  lent_or_stop_.post();
  if (given_back_.wait_until(steady_now_ns() + timeout_ms * kMillisecond_ns)) return status_;
  if (lent_.exchange(nullptr) != nullptr) return ReadStatus::kTimeout;
  given_back_.wait();  // it is being written
  return status_;
}

void LcmSource::hear() {
  while (!stopping_) {
    if (lent_.load(std::memory_order_acquire) == nullptr) {
      lent_or_stop_.wait();
    } else if (lcm_handle_timeout(lcm_, kHearTimeout_ms) < 0 && claim() != nullptr) {
      give_back(ReadStatus::kLost, "LCM cannot be read any more");
    }
  }
}

// The frame that the reader lends. Waits for it: a message that came just when the reader's time was up is
// not lost. Null at the end.
RawFrame* LcmSource::claim() {
  while (!stopping_) {
    if (RawFrame* frame = lent_.exchange(nullptr, std::memory_order_acq_rel)) return frame;
    lent_or_stop_.wait();
  }
  return nullptr;
}

void LcmSource::give_back(ReadStatus status, const char* problem) {
  status_ = status;
  message_.clear();
  if (problem != nullptr) message_.append("lcm:").append(channel_).append(": ").append(problem);
  given_back_.post();
}

void LcmSource::receive(const lcm_recv_buf_t& received) {
  const std::int64_t arrived_ns = steady_now_ns();
  RawFrame* frame = claim();
  if (frame == nullptr) return;
  frame->captured_ns = arrived_ns;
  frame->sequence = sequence_++;
  ImagesMessage message;
  const char* problem =
      parse_images({static_cast<const std::uint8_t*>(received.data), received.data_size}, &message);
  ReadStatus status = problem == nullptr ? check_time(message.utime_us, &problem) : ReadStatus::kBad;
  if (status == ReadStatus::kFrame) status = fill(message, frame, &problem);
  give_back(status, problem);
}

ReadStatus LcmSource::check_time(std::int64_t utime_us, const char** problem) {
  const std::int64_t forward_us = utime_us - last_utime_us_;
  if (utime_us < 0 || utime_us > kLatestUtime_us) {
    *problem = "the time stamp is none";
    return ReadStatus::kBad;
  }
  if (last_utime_us_ >= 0 && forward_us <= -kRestart_us) {
    *problem = "time stamps went back by more than a second: the sender has started anew";
    return ReadStatus::kLost;
  }
  if (last_utime_us_ >= 0 && forward_us <= 0) {
    *problem = forward_us == 0 ? "a message was repeated" : "a message came after a later one";
    return ReadStatus::kBad;
  }
  last_utime_us_ = utime_us;
  return ReadStatus::kFrame;
}

// A frame whose colour is broken is one without colour.
ReadStatus LcmSource::fill(const ImagesMessage& message, RawFrame* frame, const char** problem) {
  frame->timestamp_ns = message.utime_us * 1000 + clock_offset_ns_;
  frame->depth = ImageView(frame->depth_buffer.data(), info_.camera.width, info_.camera.height);
  frame->color = {};
  *problem = decoder_.decode_depth(message, frame->depth);
  if (*problem != nullptr) return ReadStatus::kBad;
  if (info_.color_width == 0) return ReadStatus::kFrame;
  const ImageView<Rgb8> color(frame->color_buffer.data(), info_.color_width, info_.color_height);
  *problem = message.color.data.empty() ? "the colour image is missing"
                                        : decoder_.decode_color(message.color, color);
  if (*problem == nullptr) frame->color = color;
  return ReadStatus::kFrame;
}

}  // namespace loopsift
