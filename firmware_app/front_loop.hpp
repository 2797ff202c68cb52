// SPDX-License-Identifier: MIT
// The front thread's work: one frame after the other, from the queue to the pose. Never waits for the back
// thread, except at rate `max`, where the same input must give the same output. After the first frame it
// makes no heap call and takes no lock: what it has to say to a person goes into a ring that the supervisor
// reads. After a loss a new piece of the trajectory begins where the odometry was; its pose in the map is not
// known, and not published as POSE, until a correction says that an accepted loop joins it.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "core/base/arena.hpp"
#include "core/fragment/front_end.hpp"
#include "core/odometry/external_odometry.hpp"
#include "core/pipeline/corrected_trajectory.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/pipeline/slew.hpp"
#include "drivers/decode_ahead.hpp"
#include "firmware_app/back_worker.hpp"
#include "firmware_app/publisher.hpp"
#include "firmware_app/record_queue.hpp"
#include "firmware_app/run_control.hpp"
#include "firmware_app/thread_monitor.hpp"

namespace loopsift {

/// What the front thread has done so far. It writes, any thread reads.
struct FrontStatus {
  std::atomic<std::int64_t> frames{0}, tracked{0}, lost{0};
  std::atomic<std::int64_t> newest_timestamp_ns{0};  ///< of a depth image; 0 before the first
  std::atomic<bool> newest_lost{false};
  std::atomic<LostReason> lost_reason{LostReason::kNone};  ///< of the newest frame that was lost
  std::atomic<bool> anchored{true};  ///< false: the present piece of the trajectory is not joined to the map
  std::atomic<std::int32_t> fragments{0}, epoch{0};
  std::atomic<std::int64_t> poses_refused{0};
  std::atomic<std::size_t> poses{0};
};

class FrontLoop {
 public:
  struct Note {
    std::array<char, 256> text{};  ///< zero-terminated, cut to fit
  };
  static constexpr std::size_t kNotes = 16;
  /// Of the parts that it drives; all must outlive it. `given` null: the built-in odometry.
  struct Parts {
    FrameQueue& queue;
    FrontEnd& front_end;
    BackWorker& back_worker;
    Publisher& publisher;
    ExternalOdometry* given = nullptr;
  };

  /// slew: of the published corrected pose. lockstep: wait for the back thread wherever timing could change
  /// the result. max_poses: poses kept for the written trajectory; a run goes on past them.
  FrontLoop(const Parts& parts, const SlewOptions& slew, bool lockstep, std::size_t max_poses,
            RunFigures* figures, Arena& arena);

  /// Until the source's end, its loss, or an order to stop or finish. kEnd, kLost or kTimeout (ordered).
  /// Front thread.
  [[nodiscard]] ReadStatus run(const RunControl& control, ThreadMonitor* monitor, ThreadTenure* tenure);

  // After run(), any one thread.
  /// Closes the last fragment.
  void close_last();
  /// Takes the back thread's corrections into the pose.
  void apply_corrections();
  [[nodiscard]] Span<const OdometryPose> poses() const { return {poses_.data(), status_.poses.load()}; }
  [[nodiscard]] const Se3& T_map_odom() const { return T_map_odom_; }
  /// Why the source was lost.
  [[nodiscard]] const char* message() const { return parts_.queue.message(); }

  // Any thread.
  [[nodiscard]] const FrontStatus& status() const { return status_; }
  /// The supervisor's alone: the next thing to tell a person.
  [[nodiscard]] bool next_note(Note* note) { return notes_.pop(note); }
  /// Poses kept, and notes. Allocates.
  [[nodiscard]] std::vector<PoolFigures> pools() const;

 private:
  void take(const RawFrame& raw, ThreadMonitor* monitor);
  void keep(const FrontEndResult& result, std::int64_t captured_ns);
  void hand_over(std::int64_t timestamp_ns);
  void note_times(const FrontEndResult& result, std::int64_t start_ns, const RawFrame& raw);
  void note_state(const FrontEndResult& result);
  void begin_piece(FrameId frame);
  void note_skipped();
  void note(const char* text);

  Parts parts_;
  bool lockstep_;
  RunFigures& figures_;
  Span<OdometryPose> poses_;
  RecordQueue<Note> notes_;
  FrontStatus status_;
  CorrectionRecord correction_;
  Se3 T_odom_camera_, T_map_odom_;
  Slew slew_;                // what POSE shows of T_map_odom_
  std::int32_t piece_ = -1;  // number of the frame that the present piece of the trajectory began with
  std::int64_t first_timestamp_ns_ = 0, last_timestamp_ns_ = 0;
};

}  // namespace loopsift
