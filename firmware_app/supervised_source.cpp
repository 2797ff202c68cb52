// SPDX-License-Identifier: MIT
#include "firmware_app/supervised_source.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::size_t kMessageBytes = 512;
constexpr int kLook_ms = 5;  // between looks whether a wait is over

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

std::int64_t delay_ns(const RetryOptions& options, int tries) {
  const double doubled = options.retry_first_ms * std::exp2(std::min(tries, 30));
  return static_cast<std::int64_t>(std::min(doubled, options.retry_max_ms) * kMillisecond_ns);
}

std::string size_of(const SourceInfo& info) {
  return std::to_string(info.camera.width) + " x " + std::to_string(info.camera.height) + " depth, " +
         std::to_string(info.color_width) + " x " + std::to_string(info.color_height) + " colour";
}

// Why a source may not take the place of the one that the memory was made for; empty: it may.
std::string difference(const SourceInfo& first, const SourceInfo& now) {
  if (first.camera.width != now.camera.width || first.camera.height != now.camera.height ||
      first.color_width != now.color_width || first.color_height != now.color_height)
    return "came back with other images (" + size_of(now) + "; the run began with " + size_of(first) + ")";
  constexpr float kSamePixels = 1.0F;
  const PinholeCamera &a = first.camera, &b = now.camera;
  const float apart = std::max(std::max(std::abs(a.fx - b.fx), std::abs(a.fy - b.fy)),
                               std::max(std::abs(a.cx - b.cx), std::abs(a.cy - b.cy)));
  if (apart > kSamePixels || first.depth_unit_m != now.depth_unit_m)
    return "came back as another camera (its focal lengths, centre or depth unit differ)";
  return {};
}

void rest(std::int64_t time_ns) {
  Semaphore never_posted;
  (void)never_posted.wait_until(steady_now_ns() + time_ns);
}

}  // namespace

SupervisedSource::SupervisedSource(std::unique_ptr<FrameSource> source, SourceOpener open,
                                   const RetryOptions& options)
    : open_(std::move(open)), options_(options), info_(source->info()), source_(std::move(source)) {
  why_.reserve(kMessageBytes);
}

SupervisedSource::~SupervisedSource() {
  while (!end(1000)) {
  }
}

void SupervisedSource::start() {
  if (info_.live && options_.retry_limit != 0) thread_ = std::thread([this] { run(); });
}

bool SupervisedSource::end(int limit_ms) {
  if (!thread_.joinable()) return true;
  stopping_ = true;
  lost_or_stop_.post();
  for (int waited_ms = 0; !ended_; waited_ms += kLook_ms) {
    if (waited_ms >= limit_ms) return false;
    rest(kLook_ms * kMillisecond_ns);
  }
  thread_.join();
  return true;
}

const std::string& SupervisedSource::message() const {
  static const std::string nothing;
  if (source_) return source_->message();
  return given_up_ ? why_ : nothing;
}

ReadStatus SupervisedSource::read(RawFrame& frame, int timeout_ms) {
  if (!source_) return wait_for_return(timeout_ms);
  if (silent_since_ns_ == 0) silent_since_ns_ = steady_now_ns();
  const ReadStatus status = source_->read(frame, timeout_ms);
  if (status == ReadStatus::kFrame) take(&frame);
  if (!thread_.joinable()) return status;
  if (status == ReadStatus::kLost) {
    let_go(source_->message().c_str());
    return ReadStatus::kTimeout;
  }
  if (status == ReadStatus::kTimeout && is_stalled()) {
    char text[96];
    std::snprintf(text, sizeof text, "no frame for %.1f s", seconds(steady_now_ns() - silent_since_ns_));
    let_go(text);
  }
  return status;
}

bool SupervisedSource::is_stalled() const {
  const double silent_s = seconds(steady_now_ns() - silent_since_ns_);
  return options_.stall_periods > 0 && silent_s * info_.nominal_rate_hz > options_.stall_periods;
}

void SupervisedSource::take(RawFrame* frame) {
  silent_since_ns_ = steady_now_ns();
  if (warming_) {  // the first of an opening
    if (session_ > 0) join_to_last(*frame);
    tries_ = 0;
    away_ = false;
    warming_ = false;
  }
  frame->session = session_;
  frame->timestamp_ns += clock_shift_ns_;
  frame->sequence += sequence_shift_;
  last_timestamp_ns_ = frame->timestamp_ns;
  last_sequence_ = frame->sequence;
  last_arrival_ns_ = silent_since_ns_;
}

// Time stamps that would go back are moved to where the host's clock has them.
void SupervisedSource::join_to_last(const RawFrame& first) {
  returns_.fetch_add(1, std::memory_order_relaxed);
  sequence_shift_ = last_sequence_ + 1 - first.sequence;
  clock_shift_ns_ = 0;
  if (first.timestamp_ns <= last_timestamp_ns_)
    clock_shift_ns_ = last_timestamp_ns_ + std::max<std::int64_t>(1, silent_since_ns_ - last_arrival_ns_) -
                      first.timestamp_ns;
}

// Hands the source over to be closed and opened again.
void SupervisedSource::let_go(const char* why) {
  why_.assign(why, strnlen(why, kMessageBytes - 1));
  handed_ = std::move(source_);
  away_ = true;
  lost_or_stop_.post();
}

ReadStatus SupervisedSource::wait_for_return(int timeout_ms) {
  if (given_up_) return ReadStatus::kLost;
  if (!back_or_given_up_.wait_until(steady_now_ns() + timeout_ms * kMillisecond_ns))
    return ReadStatus::kTimeout;
  source_ = std::move(handed_);
  given_up_ = source_ == nullptr;
  if (given_up_) return ReadStatus::kLost;
  ++session_;
  silent_since_ns_ = 0;
  warming_ = true;
  return ReadStatus::kTimeout;
}

void SupervisedSource::run() {
  while (!stopping_) {
    lost_or_stop_.wait();
    if (!stopping_) open_again();
  }
  ended_ = true;
}

void SupervisedSource::open_again() {
  spdlog::warn("the source was lost: {}; trying to open it again", why_);
  handed_.reset();
  std::string problem, told;
  while (options_.retry_limit < 0 || tries_ < options_.retry_limit) {
    if (lost_or_stop_.wait_until(steady_now_ns() + delay_ns(options_, tries_)) || stopping_) return;
    ++tries_;
    if (try_to_open(&problem)) {
      spdlog::warn("the source is open again, at try {}", tries_.load());
      return back_or_given_up_.post();
    }
    if (problem != told) spdlog::warn("the source cannot be opened again yet: {}", problem);
    told = problem;
  }
  why_ += "; " + std::to_string(tries_) + " tries to open it again failed (source.retry_limit)";
  if (!problem.empty()) why_ += ", the last: " + problem;
  back_or_given_up_.post();
}

bool SupervisedSource::try_to_open(std::string* problem) {
  auto opened = open_();
  *problem = opened.ok() ? difference(info_, (*opened)->info()) : opened.error().message;
  if (!problem->empty()) return false;
  handed_ = std::move(*opened);
  return true;
}

Expected<std::unique_ptr<FrameSource>> open_patiently(const SourceOpener& open, const RetryOptions& options,
                                                      const std::atomic<bool>& stop) {
  auto source = open();
  for (int tries = 0; !source.ok() && tries < options.first_retry_limit && !stop; ++tries) {
    const ErrorCode code = source.error().code;
    if (code != ErrorCode::kNotFound && code != ErrorCode::kIo) break;  // trying again will not help
    if (tries == 0) spdlog::warn("{}; waiting for it", source.error().message);
    rest(delay_ns(options, tries));
    source = open();
  }
  return source;
}

}  // namespace loopsift
