// SPDX-License-Identifier: MIT
// The bodies of Subscriber; included by subscriber.hpp alone.
#pragma once
#include <algorithm>
#include <iterator>

#include "loopsift/client/subscriber.hpp"

namespace loopsift::client {

inline Subscriber::Subscriber(lcm::LCM& lcm, SubscriberOptions options)
    : lcm_(lcm), options_(std::move(options)) {
  std::random_device random;
  while (sender_ == 0) sender_ = static_cast<std::int64_t>(random()) << 31 ^ random();
  constexpr int kQueued = 4096;  // messages; the map comes in bursts
  for (const char* channel : {"LOOPSIFT_POSE", "LOOPSIFT_CORRECTION", "LOOPSIFT_LOOP", "LOOPSIFT_HEALTH",
                              "LOOPSIFT_ACK", "LOOPSIFT_FRAGMENT", "LOOPSIFT_GRAPH"}) {
    const std::string name = channel;
    if (!options_.want_map && (name == "LOOPSIFT_FRAGMENT" || name == "LOOPSIFT_GRAPH")) continue;
    subscriptions_.push_back(lcm_.subscribeFunction(options_.prefix + name, &Subscriber::pass_on, this));
    subscriptions_.back()->setQueueCapacity(kQueued);
  }
}

inline Subscriber::~Subscriber() {
  for (lcm::Subscription* subscription : subscriptions_) lcm_.unsubscribe(subscription);
}

inline void Subscriber::receive(const lcm::ReceiveBuffer* received, const std::string& channel) {
  const std::string name = channel.substr(options_.prefix.size());
  bool good = false;
  if (name == "LOOPSIFT_POSE") good = decode_and_take(*received, &Subscriber::take_pose);
  if (name == "LOOPSIFT_CORRECTION") good = decode_and_take(*received, &Subscriber::take_correction);
  if (name == "LOOPSIFT_LOOP") good = decode_and_take(*received, &Subscriber::take_loop);
  if (name == "LOOPSIFT_HEALTH") good = decode_and_take(*received, &Subscriber::take_health);
  if (name == "LOOPSIFT_ACK") good = decode_and_take(*received, &Subscriber::take_ack);
  if (name == "LOOPSIFT_FRAGMENT") good = decode_and_take(*received, &Subscriber::take_fragment);
  if (name == "LOOPSIFT_GRAPH") good = decode_and_take(*received, &Subscriber::take_graph);
  if (!good) ++refused_;
}

template <class Message>
bool Subscriber::decode_and_take(const lcm::ReceiveBuffer& received,
                                 bool (Subscriber::*take)(const Message&)) {
  constexpr std::uint32_t kLargest = 65'536;
  if (received.data_size > kLargest) return false;
  const int size = static_cast<int>(received.data_size);
  Message message;
  try {
    if (message.decode(received.data, 0, size) != size) return false;
  } catch (const std::exception&) {  // a text of negative length
    return false;
  }
  return (this->*take)(message);
}

/// A later run makes all that is known of the old one worthless; an earlier one is out of date.
inline bool Subscriber::is_this_run(std::int64_t run) {
  if (run < run_ || run <= 0) return false;
  if (run == run_) return true;
  run_ = run;
  ++runs_seen_;
  history_.clear();
  corrections_.clear();
  loops_.clear();
  answers_.clear();
  health_.reset();
  map_ = Map();
  asked_ = map_came_ = {};
  return true;
}

inline bool Subscriber::take_pose(const pose_t& m) {
  Pose pose;
  pose.utime = m.utime;
  pose.captured_utime = m.captured_utime;
  pose.epoch = m.epoch;
  pose.piece = m.piece;
  pose.anchored = m.anchored != 0;
  pose.T_odom_body = make_transform(m.T_odom_body.trans, m.T_odom_body.quat);
  pose.T_map_body = make_transform(m.T_map_body.trans, m.T_map_body.quat);
  std::copy(std::begin(m.covariance), std::end(m.covariance), pose.covariance.begin());
  if (m.epoch < 0 || !is_valid(pose.T_odom_body) || !is_valid(pose.T_map_body)) return false;
  if (!is_this_run(m.run)) return false;
  if (!history_.empty() && pose.utime <= history_.back().utime) return false;
  history_.push_back(pose);
  const auto oldest = pose.utime - static_cast<std::int64_t>(options_.history_s * 1e6);
  while (history_.front().utime < oldest) history_.pop_front();
  return true;
}

inline bool Subscriber::take_correction(const correction_t& m) {
  if (m.epoch < 1 || !is_valid(make_transform(m.T_map_odom.trans, m.T_map_odom.quat)) ||
      !std::isfinite(m.jump_translation_m) || !std::isfinite(m.jump_rotation_rad) || !is_this_run(m.run))
    return false;
  const bool is_newer = corrections_.empty() || m.epoch > corrections_.back().epoch;
  if (is_newer) corrections_.push_back(m);
  return is_newer || m.epoch == corrections_.back().epoch;  // sent again because someone asked
}

inline bool Subscriber::take_loop(const loop_t& m) {
  if (m.id < 0 || m.fragment_i < 0 || m.fragment_j < 0 || m.decision < loop_t::REJECTED ||
      m.decision > loop_t::DROPPED || !is_valid(make_transform(m.T_i_j.trans, m.T_i_j.quat)) ||
      !is_this_run(m.run))
    return false;
  const auto known = loops_.find(m.id);
  if (known != loops_.end() && known->second.utime > m.utime) return false;
  loops_[m.id] = m;
  return true;
}

inline bool Subscriber::take_health(const health_t& m) {
  if (m.state < health_t::STARTING || m.state > health_t::FINISHING || m.fragments < 0 || m.epoch < 0 ||
      m.graph_version < 0 || m.n_latency < 0 || m.n_latency > static_cast<int>(std::size(m.latency)) ||
      m.n_threads < 0 || m.n_threads > static_cast<int>(std::size(m.threads)) || m.n_pools < 0 ||
      m.n_pools > static_cast<int>(std::size(m.pools)) || !is_this_run(m.run))
    return false;
  if (health_ && m.uptime_s < health_->uptime_s) return false;
  health_ = m;
  return true;
}

inline bool Subscriber::take_fragment(const fragment_t& m) {
  if (m.run <= 0 || m.run < run_) return false;
  if (m.run != run_ && !Map().add(m)) return false;  // nonsense must not end a run
  (void)is_this_run(m.run);
  map_came_ = Clock::now();
  return map_.add(m);
}

inline bool Subscriber::take_graph(const graph_t& m) {
  if (m.run <= 0 || m.run < run_) return false;
  if (m.run != run_ && !Map().add(m)) return false;
  (void)is_this_run(m.run);
  map_came_ = Clock::now();
  return map_.add(m);
}

inline bool Subscriber::take_ack(const ack_t& m) {
  if (m.status < ack_t::DONE || m.status > ack_t::REFUSED) return false;
  if (m.sender != sender_) return true;  // somebody else's
  if (!is_this_run(m.run)) return false;
  constexpr std::size_t kKept = 64;
  answers_[m.number] = m;
  if (answers_.size() > kKept) answers_.erase(answers_.begin());
  return true;
}

inline std::optional<Pose> Subscriber::pose() const {
  if (history_.empty()) return std::nullopt;
  return history_.back();
}

inline Transform Subscriber::T_map_odom() const {
  if (!history_.empty() && (corrections_.empty() || history_.back().epoch >= corrections_.back().epoch))
    return history_.back().T_map_body * history_.back().T_odom_body.inverse();
  if (corrections_.empty()) return {};
  const auto& T = corrections_.back().T_map_odom;
  return make_transform(T.trans, T.quat);
}

inline std::optional<Pose> Subscriber::pose_at(std::int64_t utime) const {
  const auto after = std::lower_bound(history_.begin(), history_.end(), utime,
                                      [](const Pose& pose, std::int64_t t) { return pose.utime < t; });
  if (after == history_.end()) return std::nullopt;
  Pose result = *after;
  if (after->utime > utime) {
    if (after == history_.begin()) return std::nullopt;
    const Pose& before = *std::prev(after);
    const double s =
        static_cast<double>(utime - before.utime) / static_cast<double>(after->utime - before.utime);
    result = before;
    result.T_odom_body = interpolate(before.T_odom_body, after->T_odom_body, s);
    result.utime = utime;
  }
  result.T_map_body = T_map_odom() * result.T_odom_body;
  return result;
}

inline bool Subscriber::state_missing() const {
  if (!health_) return true;
  const std::int32_t epoch = corrections_.empty() ? 0 : corrections_.back().epoch;
  return health_->epoch > epoch || health_->loops_decided > static_cast<std::int32_t>(loops_.size());
}

inline bool Subscriber::complete() const {
  if (state_missing()) return false;
  return !options_.want_map || (map_.complete() && map_.graph().version >= health_->graph_version);
}

inline void Subscriber::poll() {
  constexpr double kBetweenQuestions_s = 0.1;
  if (seconds_since(asked_) < kBetweenQuestions_s) return;
  if (seconds_since(map_came_) < options_.quiet_s && seconds_since(asked_) < options_.patience_s) return;
  command_t command{};
  if (state_missing()) {
    command.object[command.n_objects++] = command_t::STATE;
    command.object[command.n_objects++] = command_t::LOOPS;
  }
  const bool no_graph = health_ && health_->graph_version == 0;
  if (options_.want_map && !no_graph) (void)map_.add_missing(health_ ? health_->graph_version : 0, &command);
  if (command.n_objects == 0) return;
  command.command = command_t::RESEND;
  asked_ = Clock::now();
  transmit(&command);
}

inline std::int32_t Subscriber::send(std::int8_t command) {
  command_t message{};
  message.command = command;
  transmit(&message);
  return message.number;
}

inline void Subscriber::transmit(command_t* command) {
  using std::chrono::microseconds;
  command->utime =
      std::chrono::duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  command->run = run_;
  command->sender = sender_;
  command->number = ++number_;
  (void)lcm_.publish(options_.prefix + "LOOPSIFT_COMMAND", command);
}

inline std::optional<ack_t> Subscriber::answer(std::int32_t number) const {
  const auto found = answers_.find(number);
  if (found == answers_.end()) return std::nullopt;
  return found->second;
}

}  // namespace loopsift::client
