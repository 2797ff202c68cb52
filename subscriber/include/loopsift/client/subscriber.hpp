// SPDX-License-Identifier: MIT
// Everything that loopsift publishes, as state to ask for: the pose now and at a time, corrections, loops,
// health, and the map, whenever the subscriber joins and however much of the bus is lost on the way.
//
//   lcm::LCM lcm("udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152");
//   loopsift::client::Subscriber loopsift(lcm);
//   while (lcm.handleTimeout(50) >= 0) {
//     loopsift.poll();
//     if (auto pose = loopsift.pose()) use(*pose);
//   }
//
// Messages are trusted no further than they go: what cannot be decoded, is out of range, not a number, older
// than what is known, or of an earlier run is refused and counted. A new run of the program resets all.
// One thread: the one that calls handle() and poll(). Allocates.
#pragma once
#include <array>
#include <bot_core/pose_t.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <loopsift/ack_t.hpp>
#include <loopsift/command_t.hpp>
#include <loopsift/correction_t.hpp>
#include <loopsift/health_t.hpp>
#include <loopsift/loop_t.hpp>
#include <loopsift/pose_t.hpp>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "loopsift/client/map.hpp"
#include "loopsift/client/transform.hpp"

namespace loopsift::client {

struct SubscriberOptions {
  std::string prefix;       ///< of the channels, as the program's lcm.prefix
  bool want_map = true;     ///< false: surfels and graph are neither listened to nor asked for
  double history_s = 60;    ///< how far back pose_at() reaches
  double quiet_s = 0.08;    ///< without a chunk of the map: what is missing is asked for
  double patience_s = 1.0;  ///< between two questions while chunks come
};

/// A pose with what is known about it.
struct Pose {
  std::int64_t utime = 0;           ///< µs, time of the depth image
  std::int64_t captured_utime = 0;  ///< µs since 1970, the program's host: when the frame came in
  std::int32_t epoch = 0;           ///< of the correction in T_map_body
  std::int32_t piece = 0;           ///< another value is another odom: tracking was lost in between
  bool anchored = true;   ///< false: T_map_body is not known, as no accepted loop joins the piece to the map
  Transform T_odom_body;  ///< smooth; drifts, never jumps
  Transform T_map_body;   ///< corrected
  std::array<double, 36>
      covariance;  ///< of T_map_body: row-major, (t, ω), m and rad, on the right; NaN: unknown
};

class Subscriber {
 public:
  explicit Subscriber(lcm::LCM& lcm, SubscriberOptions options = {});
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  /// The newest pose.
  [[nodiscard]] std::optional<Pose> pose() const;
  /// The pose at a time within the last history_s, in today's map: the odometry's motion is interpolated, the
  /// newest correction applied. Covariance and epoch are those of the pose before it.
  [[nodiscard]] std::optional<Pose> pose_at(std::int64_t utime) const;
  /// Maps points of odom to map: identity before the first correction.
  [[nodiscard]] Transform T_map_odom() const;
  /// All that came, oldest first.
  [[nodiscard]] const std::deque<correction_t>& corrections() const { return corrections_; }
  /// The last decision about each loop, by id.
  [[nodiscard]] const std::map<std::int32_t, loop_t>& loops() const { return loops_; }
  [[nodiscard]] const std::optional<health_t>& health() const { return health_; }
  [[nodiscard]] const Map& map() const { return map_; }
  /// Nothing that the program is known to have is missing here.
  [[nodiscard]] bool complete() const;

  /// Asks for what is missing. Call it often; it sends at most about ten small messages a second.
  void poll();
  /// Sends command_t::SAVE, PAUSE, RESUME or FINISH; its number, for answer().
  std::int32_t send(std::int8_t command);
  /// The last answer to a command.
  [[nodiscard]] std::optional<ack_t> answer(std::int32_t number) const;

  [[nodiscard]] std::int64_t run() const { return run_; }          ///< µs since 1970; 0: nothing heard yet
  [[nodiscard]] std::int64_t refused() const { return refused_; }  ///< messages that made no sense
  [[nodiscard]] std::int64_t runs_seen() const { return runs_seen_; }

 private:
  using Clock = std::chrono::steady_clock;

  static void pass_on(const lcm::ReceiveBuffer* received, const std::string& channel, Subscriber* self) {
    self->receive(received, channel);
  }
  void receive(const lcm::ReceiveBuffer* received, const std::string& channel);
  template <class Message>
  bool decode_and_take(const lcm::ReceiveBuffer& received, bool (Subscriber::*take)(const Message&));
  bool take_pose(const pose_t& message);
  bool take_correction(const correction_t& message);
  bool take_loop(const loop_t& message);
  bool take_health(const health_t& message);
  bool take_fragment(const fragment_t& message);
  bool take_graph(const graph_t& message);
  bool take_ack(const ack_t& message);
  bool is_this_run(std::int64_t run);
  void transmit(command_t* command);
  [[nodiscard]] bool state_missing() const;
  [[nodiscard]] static double seconds_since(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  }

  lcm::LCM& lcm_;
  SubscriberOptions options_;
  std::vector<lcm::Subscription*> subscriptions_;
  std::int64_t sender_ = 0, run_ = 0, refused_ = 0, runs_seen_ = 0;
  std::int32_t number_ = 0;
  std::deque<Pose> history_;
  std::deque<correction_t> corrections_;
  std::map<std::int32_t, loop_t> loops_;
  std::map<std::int32_t, ack_t> answers_;
  std::optional<health_t> health_;
  Map map_;
  Clock::time_point asked_{}, map_came_{};
};

}  // namespace loopsift::client

#include "loopsift/client/subscriber_inline.hpp"
