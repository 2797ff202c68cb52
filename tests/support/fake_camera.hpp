// SPDX-License-Identifier: MIT
// A camera on a cable that tests pull and plug in again: sources that open, give frames, fall silent or are
// lost as a script says.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "drivers/frame_source.hpp"

namespace loopsift::test {

/// What all openings of the camera share.
struct Cable {
  SourceInfo info;
  std::atomic<int> frames_left{0};         ///< then it is lost, or silent
  std::atomic<bool> silent_at_end{false};  ///< instead of lost
  std::atomic<int> refusals{0};            ///< openings that fail before the next one succeeds
  std::atomic<int> frames_after{0};        ///< that the next opening gives
  std::atomic<int> opened{0}, tried{0}, alive{0};
  std::int64_t first_timestamp_ns = 0;  ///< of each opening: a device's clock starts anew
  std::function<void(RawFrame*)> draw = [](RawFrame* frame) { frame->depth_buffer[0] = 1; };
};

class FakeCamera final : public FrameSource {
 public:
  explicit FakeCamera(Cable& cable) : cable_(cable), info_(cable.info) { ++cable_.alive; }
  ~FakeCamera() override { --cable_.alive; }
  FakeCamera(const FakeCamera&) = delete;
  FakeCamera& operator=(const FakeCamera&) = delete;

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] const std::string& message() const override { return message_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int /*timeout_ms*/) override {
    message_.clear();
    if (cable_.frames_left == 0 && cable_.silent_at_end) return ReadStatus::kTimeout;
    if (cable_.frames_left == 0) {
      message_ = "pulled out";
      return ReadStatus::kLost;
    }
    --cable_.frames_left;
    frame.sequence = next_;
    frame.timestamp_ns = cable_.first_timestamp_ns + next_++ * 33'333'333;
    frame.depth = ImageView(frame.depth_buffer.data(), info_.camera.width, info_.camera.height);
    frame.color = {};
    cable_.draw(&frame);
    return ReadStatus::kFrame;
  }

  /// What opens it, as open_source() would.
  static Expected<std::unique_ptr<FrameSource>> open(Cable& cable) {
    ++cable.tried;
    if (cable.refusals > 0) {
      --cable.refusals;
      return Error{ErrorCode::kNotFound, "fake: no such device"};
    }
    ++cable.opened;
    cable.frames_left = cable.frames_after.load();
    return std::unique_ptr<FrameSource>(std::make_unique<FakeCamera>(cable));
  }

 private:
  Cable& cable_;
  SourceInfo info_;
  std::int64_t next_ = 0;
  std::string message_;
};

}  // namespace loopsift::test
