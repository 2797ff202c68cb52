// SPDX-License-Identifier: MIT
#include "drivers/paired_source.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr double kPatiencePeriods = 0.8;           // leaves time to be back for the next depth frame
constexpr int kSilentFrames = 10;                  // after which colour is no longer waited for
constexpr std::int64_t kFarAhead_ns = 1000000000;  // a live camera's time stamp is wrong by then
constexpr double kUsualRate_hz = 30.0;
constexpr std::size_t kMessageBytes = 1024;

std::int64_t period_ns(const SourceInfo& info) {
  return static_cast<std::int64_t>(1e9 / (info.nominal_rate_hz > 0 ? info.nominal_rate_hz : kUsualRate_hz));
}

std::size_t pixels(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> PairedSource::create(std::unique_ptr<FrameSource> depth,
                                                            std::unique_ptr<FrameSource> color) {
  if (color->info().color_width == 0)
    return Error{ErrorCode::kUsage, color->info().description +
                                        " gives no colour; camera.color_source "
                                        "must name a source that does"};
  if (depth->info().camera.width == 0)
    return Error{ErrorCode::kUsage, depth->info().description +
                                        " gives no depth; name the depth camera as "
                                        "the source and this as camera.color_source"};
  if (depth->info().live != color->info().live)
    return Error{ErrorCode::kUsage, "camera.color_source: a camera and a recording cannot be paired: " +
                                        depth->info().description + "; " + color->info().description};
  return std::unique_ptr<FrameSource>(std::make_unique<PairedSource>(std::move(depth), std::move(color)));
}

PairedSource::PairedSource(std::unique_ptr<FrameSource> depth, std::unique_ptr<FrameSource> color)
    : depth_(std::move(depth)), color_(std::move(color)), info_(depth_->info()) {
  const SourceInfo& colored = color_->info();
  window_ns_ = std::min(period_ns(info_), period_ns(colored)) / 2;
  patience_ns_ = static_cast<std::int64_t>(kPatiencePeriods * static_cast<double>(period_ns(info_)));
  info_.description += "; colour: " + colored.description;
  info_.color_width = colored.color_width;
  info_.color_height = colored.color_height;
  ahead_.resize(pixels(colored.color_width, colored.color_height));
  unused_.resize(pixels(colored.camera.width, colored.camera.height));
  message_.reserve(kMessageBytes);
}

ReadStatus PairedSource::read(RawFrame& frame, int timeout_ms) {
  message_.clear();
  const ReadStatus status = depth_->read(frame, timeout_ms);
  note(depth_->message());
  if (status != ReadStatus::kFrame) return status;
  frame.color = {};
  color_frame_.color_buffer = frame.color_buffer;
  color_frame_.depth_buffer = unused_;
  if (find_color(frame)) {
    frame.color = color_frame_.color;
    ++counts_.paired;
    return status;
  }
  ++counts_.missing;
  if (message_.empty()) note("no colour image within half a frame period");
  return status;
}

PairedSource::Fit PairedSource::fit(std::int64_t color_ns, std::int64_t depth_ns) const {
  if (color_ns < depth_ns - window_ns_) return Fit::kTooEarly;
  return color_ns <= depth_ns + window_ns_ ? Fit::kPair : Fit::kTooLate;
}

// Whether color_frame_.color is the one that belongs to `frame`.
bool PairedSource::find_color(const RawFrame& frame) {
  bool found = false;
  if (!take_ahead(frame, &found)) return found;
  ++silent_frames_;
  const std::int64_t deadline_ns = silent_frames_ <= kSilentFrames ? steady_now_ns() + patience_ns_ : 0;
  while (read_color(frame, deadline_ns)) {
    switch (fit(color_frame_.timestamp_ns, frame.timestamp_ns)) {
      case Fit::kPair:
        return true;
      case Fit::kTooLate:
        keep_ahead();
        return false;
      case Fit::kTooEarly:
        ++counts_.unused;
    }
  }
  return false;
}

// Looks at the frame that was kept. False when no other has to be read.
bool PairedSource::take_ahead(const RawFrame& frame, bool* found) {
  if (!has_ahead_) return true;
  const Fit fits = fit(ahead_ns_, frame.timestamp_ns);
  const bool impossible = info_.live && ahead_ns_ > frame.timestamp_ns + kFarAhead_ns;
  if (fits == Fit::kTooLate && !impossible) return false;
  has_ahead_ = false;
  if (fits != Fit::kPair) {
    ++counts_.unused;
    return true;
  }
  color_frame_.color = {frame.color_buffer.data(), info_.color_width, info_.color_height};
  std::memcpy(static_cast<void*>(frame.color_buffer.data()), ahead_.data(), ahead_.size() * sizeof(Rgb8));
  *found = true;
  return false;
}

// The next usable colour frame into color_frame_; false when there is none in time.
bool PairedSource::read_color(const RawFrame& frame, std::int64_t deadline_ns) {
  assert(frame.color_buffer.size() >= ahead_.size());
  (void)frame;
  while (!color_over_) {
    const std::int64_t left_ms = (deadline_ns - steady_now_ns() + 999999) / 1000000;
    const auto status =
        color_->read(color_frame_, static_cast<int>(std::clamp<std::int64_t>(left_ms, 0, 1000)));
    if (status == ReadStatus::kTimeout) return false;
    if (status == ReadStatus::kEnd || status == ReadStatus::kLost) {
      color_over_ = true;
      note(color_->message());
      return false;
    }
    silent_frames_ = 0;
    if (status == ReadStatus::kBad || color_frame_.color.empty()) {
      ++counts_.bad;
      note(color_->message());
      continue;
    }
    const bool repeated = has_last_color_ && color_frame_.timestamp_ns == last_color_ns_;
    last_color_ns_ = color_frame_.timestamp_ns;
    has_last_color_ = true;
    if (!repeated) return true;
    ++counts_.repeated;
  }
  return false;
}

void PairedSource::keep_ahead() {
  std::memcpy(static_cast<void*>(ahead_.data()), color_frame_.color.data, ahead_.size() * sizeof(Rgb8));
  ahead_ns_ = color_frame_.timestamp_ns;
  has_ahead_ = true;
}

// Never beyond what is reserved.
void PairedSource::note(std::string_view problem) {
  if (!problem.empty()) message_.assign(problem.substr(0, kMessageBytes));
}

}  // namespace loopsift
