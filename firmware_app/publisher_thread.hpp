// SPDX-License-Identifier: MIT
// The inside of Publisher: its rings, its messages and its two threads. Only publisher*.cpp include it.
#pragma once
#include <lcm/lcm.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>

#include "core/base/semaphore.hpp"
#include "core/base/steady_time.hpp"
#include "firmware_app/publisher.hpp"
#include "firmware_app/publisher_commands.hpp"
#include "firmware_app/publisher_covariance.hpp"
#include "firmware_app/publisher_graph.hpp"
#include "firmware_app/publisher_health.hpp"
#include "firmware_app/publisher_messages.hpp"
#include "firmware_app/publisher_wanted.hpp"
#include "firmware_app/record_queue.hpp"

namespace loopsift {

/// How many bytes of the map may go out now: a bucket that fills at a steady rate and holds little, so that a
/// receiver's socket buffer is not flooded.
class Pacer {
 public:
  explicit Pacer(double bytes_per_s) : bytes_per_s_(bytes_per_s) {}
  /// Whether another message may go out.
  [[nodiscard]] bool allows(std::int64_t now_ns) {
    available_ += bytes_per_s_ * static_cast<double>(now_ns - filled_ns_) * 1e-9;
    available_ = std::min(available_, kMost);
    filled_ns_ = now_ns;
    return available_ > 0;
  }
  void spend(int bytes) { available_ -= bytes; }

 private:
  static constexpr double kMost = 48 * 1024;
  double bytes_per_s_, available_ = kMost;
  std::int64_t filled_ns_ = 0;
};

struct Publisher::Impl {
  Impl(const LcmSettings& lcm_settings, Arena& arena, const GraphLimits& limits);

  template <class Record>
  bool queue(RecordQueue<Record>& queue, const Record& record) {
    if (lcm == nullptr || !queue.push(record)) return false;
    wake.post();
    return true;
  }

  // Set-up.
  void send_first_update();
  void listen();
  // Publish thread.
  void run();
  void work();
  void last_words();
  void send_poses();
  void send_corrections();
  void send_loops();
  void send_acks();
  void send_health();
  void obey_requests();
  void follow_store();
  void follow_graph();
  void send_map();
  void send(const PoseRecord& record);
  void send(const CorrectionRecord& record);
  void send(const LoopRecord& record);
  void send_state();
  int send_chunk(std::int32_t object, std::int32_t chunk);
  template <class Message>
  int send(Channel channel, const Message& message);
  // Listening thread.
  void hear() const;
  void receive(const lcm_recv_buf_t& received);
  void receive_loop(const lcm_recv_buf_t& received);

  LcmSettings settings;
  std::array<std::string, kChannelNames.size()> channels;
  RecordQueue<PoseRecord> poses;
  RecordQueue<CorrectionRecord> corrections;
  RecordQueue<LoopRecord> loops;
  RecordQueue<RunHealth> health;
  RecordQueue<CheckedCommand> requests;                      // listening → publish: RESEND
  RecordQueue<Command> commands;                             // listening → whoever takes commands
  RecordQueue<OutsideLoop> loops_in;                         // listening → back
  RecordQueue<AckRecord> acks_heard, acks_taker, acks_back;  // by the thread that answers
  GraphExchange graph;
  Span<std::byte> buffer;
  Span<LoopRecord> loop_table;  // by id
  const FragmentStore* store = nullptr;
  ThreadMonitor* monitor = nullptr;

  lcm_t* lcm = nullptr;  // set before the threads start, cleared after they ended
  std::int64_t run_id = 0;
  std::thread publish_thread, listen_thread;
  Semaphore wake;
  std::atomic<bool> stopping{false}, deaf{false}, paused{false};
  std::array<std::atomic<std::int64_t>, kChannelNames.size()> sent{};
  std::atomic<std::int64_t> failed{0}, obeyed{0}, refused{0};
  std::atomic<std::int64_t> last_words_ns{kLastWords_ns};
  std::atomic<std::int32_t> fragment_count{0};  // that can be asked for

  CommandGate gate{0, 0};  // listening thread

  // Publish thread only.
  BodyVelocity velocity;
  CovarianceTracker covariance;
  WantedChunks wanted;
  std::int32_t loop_count = 0;     // one more than the highest id in the table
  std::int32_t loops_decided = 0;  // in the table
  Pacer pacer;
  std::int32_t graph_epoch_sent = 0;
  std::int64_t graph_sent_ns = 0;
  bool graph_held_back = false;
  bot_core::pose_t pose_message{};
  pose_t full_pose_message{};
  correction_t correction_message{};
  bot_frames::update_t update_message{};
  loop_t loop_message{};
  ack_t ack_message{};
  fragment_t fragment_message{};
  graph_t graph_message{};
  health_t health_message = make_health_message();
  CheckedCommand request;
  CorrectionRecord correction;
};

/// Microseconds since 1970.
[[nodiscard]] std::int64_t wall_clock_us();

}  // namespace loopsift
