// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/posed_sequence.hpp"

#include <cstdio>

namespace loopsift::tool {
namespace {
constexpr int kReadTimeout_ms = 1000;  // recordings do not time out; it only bounds one wait
}

PosedSequence::PosedSequence(FrameSource& source, const GivenOdometry& odometry, Arena& arena)
    : queue_(source, {}, arena), odometry_(odometry) {}

Expected<const PosedFrame*> PosedSequence::next() {
  if (!started_) queue_.start();
  started_ = true;
  if (held_ != nullptr) queue_.release(held_);
  held_ = nullptr;
  while (true) {
    switch (queue_.next(&held_, kReadTimeout_ms)) {
      case ReadStatus::kFrame:
        frame_.number = FrameId{static_cast<std::int32_t>(counts_.received++)};
        frame_.raw = held_;
        if (odometry_.pose(frame_.number, held_->timestamp_ns, &frame_.pose)) return &frame_;
        ++counts_.without_pose;
        queue_.release(held_);
        held_ = nullptr;
        break;
      case ReadStatus::kBad:
        ++counts_.received;
        ++counts_.unusable;
        std::fprintf(stderr, "loopsift-tool: frame skipped: %s\n", queue_.message());
        break;
      case ReadStatus::kTimeout:
        break;
      case ReadStatus::kEnd:
        queue_.stop();
        return nullptr;
      case ReadStatus::kLost:
        return Error{ErrorCode::kIo, "the source was lost: " + std::string(queue_.message())};
    }
  }
}

}  // namespace loopsift::tool
