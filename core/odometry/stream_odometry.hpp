// SPDX-License-Identifier: MIT
// Odometry that comes while the run goes on, pose by pose, from another program.
// In: stamped poses from one thread. Out: a TrackingResult per frame on the front thread, interpolated
// between the two poses about it. Capacity: kWaiting poses not yet looked at, kHistory behind the newest.
// Never allocates after construction.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/semaphore.hpp"
#include "core/base/spsc_ring.hpp"
#include "core/odometry/external_odometry.hpp"

namespace loopsift {

struct StreamOdometryOptions {
  double wait_ms = 30;            ///< that a frame waits for a pose after its own time, at most
  double max_gap_s = 0.1;         ///< poses farther apart are not interpolated
  double max_speed_m_per_s = 20;  ///< a faster motion is none: the stream jumped
  MotionNoise noise;
};

/// What was wrong with the stream. Written by the front thread, but for `refused`; any thread reads.
struct StreamOdometryCounts {
  std::atomic<std::int64_t> taken{0};     ///< poses in order
  std::atomic<std::int64_t> late{0};      ///< repeated, or older than the one before: not used
  std::atomic<std::int64_t> jumps{0};     ///< faster than max_speed_m_per_s: a new piece of trajectory
  std::atomic<std::int64_t> restarts{0};  ///< time went back by a second or more: a new piece
  std::atomic<std::int64_t> missing{0};   ///< frames without a pose
  std::atomic<std::int64_t> refused{0};   ///< nobody took them in time
};

class StreamOdometry final : public ExternalOdometry {
 public:
  static constexpr std::size_t kWaiting = 1024;
  static constexpr std::size_t kHistory = 256;

  explicit StreamOdometry(const StreamOdometryOptions& options);

  /// The next pose, of the camera at a time of the frames' clock. The sending thread's; never waits.
  void push(std::int64_t timestamp_ns, const Se3& T_odom_camera);
  /// Front thread. Waits for at most wait_ms.
  TrackingResult track(FrameId frame, std::int64_t timestamp_ns) override;
  [[nodiscard]] const StreamOdometryCounts& counts() const { return counts_; }

 private:
  struct Pose {
    std::int64_t timestamp_ns = 0;
    Se3 T_odom_camera;
  };
  void take_waiting();
  void take(const Pose& pose);
  void start_anew();
  [[nodiscard]] bool find(std::int64_t timestamp_ns, Se3* T_odom_camera) const;
  /// k = 0 is the newest.
  [[nodiscard]] const Pose& past(std::size_t k) const { return history_[(taken_ - 1 - k) % kHistory]; }

  StreamOdometryOptions options_;
  StreamOdometryCounts counts_;
  std::vector<Pose> storage_;
  SpscRing<Pose> waiting_;
  Semaphore arrived_;

  // Front thread's.
  std::array<Pose, kHistory> history_;
  std::size_t taken_ = 0, size_ = 0;  // poses ever put into history_; those in it that hang together
  PoseChain chain_;
};

}  // namespace loopsift
