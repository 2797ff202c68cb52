// SPDX-License-Identifier: MIT
// The publish thread: takes records from the front and back threads and sends them over LCM as POSE_ODOM,
// POSE (bot_core.pose_t), LOOPSIFT_CORRECTION, LOOPSIFT_UPDATE (bot_frames.update_t) and LOOPSIFT_LOOP.
// start() sends one LOOPSIFT_UPDATE with the identity at utime 0, so that frame clients know odom at once.
// A correction that the front thread queued before a pose goes out before that pose.
// Capacity: one ring per kind of record; a record that finds its ring full is dropped and counted. After
// start() the publish() calls and, over udpm://, the thread itself make no heap call.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/pipeline/settings.hpp"
#include "firmware_app/publisher_records.hpp"

namespace loopsift {

class Publisher {
 public:
  enum class Channel { kPoseOdom, kPose, kCorrection, kUpdate, kLoop };
  static constexpr std::array<const char*, 5> kChannelNames = {"POSE_ODOM", "POSE", "LOOPSIFT_CORRECTION",
                                                               "LOOPSIFT_UPDATE", "LOOPSIFT_LOOP"};

  /// Carves its rings; settings.prefix comes before the channel names. Opens nothing.
  Publisher(const LcmSettings& settings, Arena& arena);
  /// stop().
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// Opens LCM and starts the thread. Call once, before the threads that publish. kIo names the remedy (no
  /// multicast route, say); the object then stays silent. Does nothing when settings.enabled is false.
  Status start();
  /// Sends what is queued and ends the thread. Call after the threads that publish have ended.
  void stop();
  [[nodiscard]] bool running() const;

  /// Each kind from one thread only. Never waits, never allocates. False when it was not queued: the ring is
  /// full (counted) or nothing is running.
  bool publish(const PoseRecord& record);
  bool publish(const CorrectionRecord& record);
  bool publish(const LoopRecord& record);

  /// Messages handed to LCM on a channel, and those that LCM refused on any. Any thread.
  [[nodiscard]] std::int64_t sent(Channel channel) const;
  [[nodiscard]] std::int64_t failed() const;
  /// The rings, for RunFigures::pools. After stop().
  [[nodiscard]] std::vector<PoolFigures> pools() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopsift
