// SPDX-License-Identifier: MIT
// The frames of a recording that have a pose. In: a source and a trajectory of it. Out: frames in order,
// numbered by their place in the recording: frames that cannot be read count, so that numbers hold whatever
// is broken. Reads ahead on a thread of its own; one consumer. Allocates when constructed.
#pragma once
#include <cstdint>

#include "drivers/decode_ahead.hpp"
#include "tools/loopsift_tool/given_odometry.hpp"

namespace loopsift::tool {

struct PosedFrame {
  FrameId number;
  const RawFrame* raw = nullptr;  ///< until the next call of next()
  GivenPose pose;
};

struct PosedFrameCounts {
  std::int64_t received = 0;      ///< all frames of the recording so far
  std::int64_t unusable = 0;      ///< among them those that could not be read; each was told on stderr
  std::int64_t without_pose = 0;  ///< readable, but not in the trajectory
};

class PosedSequence {
 public:
  /// Carves the frame buffers. The source is in use until next() has come to the end.
  PosedSequence(FrameSource& source, const GivenOdometry& odometry, Arena& arena);

  /// The next frame that has a pose; null at the end. Error: the source was lost.
  [[nodiscard]] Expected<const PosedFrame*> next();
  [[nodiscard]] const PosedFrameCounts& counts() const { return counts_; }

 private:
  FrameQueue queue_;
  GivenOdometry odometry_;
  RawFrame* held_ = nullptr;  // to be given back
  PosedFrame frame_;
  PosedFrameCounts counts_;
  bool started_ = false;
};

}  // namespace loopsift::tool
