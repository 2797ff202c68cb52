// SPDX-License-Identifier: MIT
// The publish thread: takes records from the other threads and sends them over LCM (kChannelNames; types and
// units in msgs/), and serves subscribers who came late or lost something: they ask on LOOPSIFT_COMMAND,
// which a thread of its own listens to. start() sends one LOOPSIFT_UPDATE with the identity at utime 0, so
// that frame clients know odom at once. A correction that the front thread queued before a pose goes out
// before that pose. Poses come before all else; chunks of the map share what LcmSettings leaves them.
//
// Capacity: one ring per kind of record; a record that finds its ring full is dropped and counted. The last
// kLoopTable loops can be had again. After start() the calls of the other threads and, over udpm://, the
// publish thread make no heap call; the listening thread does inside LCM.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/pipeline/outside_loops.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "firmware_app/publisher_records.hpp"
#include "firmware_app/run_health.hpp"
#include "firmware_app/settings.hpp"
#include "firmware_app/thread_monitor.hpp"

namespace loopsift {

/// Largest pose graph that is published.
struct GraphLimits {
  int max_fragments = 64;
  int max_nodes = 128;
  int max_edges = 512;
};

class Publisher {
 public:
  enum class Channel {
    kPoseOdom,
    kPose,
    kCorrection,
    kUpdate,
    kLoop,
    kFullPose,
    kFragment,
    kGraph,
    kHealth,
    kAck
  };
  static constexpr std::array<const char*, 10> kChannelNames = {
      "POSE_ODOM",       "POSE",          "LOOPSIFT_CORRECTION", "LOOPSIFT_UPDATE",
      "LOOPSIFT_LOOP",   "LOOPSIFT_POSE", "LOOPSIFT_FRAGMENT",   "LOOPSIFT_GRAPH",
      "LOOPSIFT_HEALTH", "LOOPSIFT_ACK"};
  static constexpr const char* kCommandChannel = "LOOPSIFT_COMMAND";
  static constexpr const char* kLoopInChannel = "LOOPSIFT_LOOP_IN";
  static constexpr std::size_t kLoopTable = 2048;
  static constexpr std::int64_t kLastWords_ns = 1'000'000'000;

  /// Carves its rings; settings.prefix comes before the channel names. Opens nothing.
  Publisher(const LcmSettings& settings, Arena& arena, const GraphLimits& limits = {});
  /// stop().
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// Opens LCM and starts the threads. Call once, before the threads that publish. Fragments of `store`,
  /// which must outlive stop(), go out as they close; null: none do. kIo names the remedy (no multicast
  /// route, say); the object then stays silent. Does nothing when settings.enabled is false.
  /// `monitor` watches the publish thread; null: nobody does.
  Status start(const FragmentStore* store = nullptr, ThreadMonitor* monitor = nullptr);
  /// Sends what is queued, what is left of the map for at most that long, and ends the threads. Call after
  /// the threads that publish have ended.
  void stop(std::int64_t last_words_ns = kLastWords_ns);
  [[nodiscard]] bool running() const;

  // Each from one thread only. Never waits, never allocates. False when it was not queued: the ring is full
  // (counted) or nothing is running.
  bool publish(const PoseRecord& record);        ///< front
  bool publish(const CorrectionRecord& record);  ///< front
  bool publish(const LoopRecord& record);        ///< back
  bool publish(const RunHealth& health);         ///< supervising
  /// Back thread. T_map_fragment has one pose for each of the store's fragments that it is handed; the graph
  /// may hold fewer. Never waits, never allocates; what is past GraphLimits is left out and counted.
  void publish(const PoseGraph& graph, Span<const Fragment> fragments, Span<const Se3> T_map_fragment,
               std::int64_t timestamp_ns, std::int32_t epoch);

  /// Supervising or front thread, one of them: the next command that is for the program and not for the
  /// publisher (all but RESEND). Each is answered by acknowledge() once. False when there is none.
  [[nodiscard]] bool take(Command* command);
  /// Back thread: the next loop that another program has sent. False when there is none.
  [[nodiscard]] bool take(OutsideLoop* loop);
  /// From the thread that takes commands, or the back thread: their answers have a ring each.
  enum class AckFrom { kTaker, kBack };
  void acknowledge(AckFrom from, const AckRecord& record);
  /// What health says about it. Any thread.
  void set_paused(bool paused);

  /// Messages handed to LCM on a channel, and those that LCM refused on any. Any thread.
  [[nodiscard]] std::int64_t sent(Channel channel) const;
  [[nodiscard]] std::int64_t failed() const;
  [[nodiscard]] std::int64_t commands_obeyed() const;
  [[nodiscard]] std::int64_t commands_refused() const;
  /// The rings, for RunFigures::pools. Any thread; allocates.
  [[nodiscard]] std::vector<PoolFigures> pools() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopsift
