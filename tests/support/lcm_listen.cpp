// SPDX-License-Identifier: MIT
// A subscriber as a process of its own: lcm_listen URL [AGES]. Prints "listening" once it hears the bus, then
// until SIGTERM counts what arrives, decodes it and checks that it makes sense; then prints JSON:
//   {"CHANNEL": {"count": 60, "bad": 0, "out_of_order": 0}, ...}
// and, where it is named, writes the file AGES: for each pose the milliseconds since its frame came in.
// Message types are told by the end of the channel's name. Exit 0, or 1 when LCM cannot be opened.
#include <lcm/lcm.h>

#include <bot_core/pose_t.hpp>
#include <bot_frames/update_t.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <loopsift/correction_t.hpp>
#include <loopsift/fragment_t.hpp>
#include <loopsift/graph_t.hpp>
#include <loopsift/health_t.hpp>
#include <loopsift/loop_t.hpp>
#include <loopsift/pose_t.hpp>
#include <map>
#include <string>

namespace {

struct Tally {
  int count = 0;
  int bad = 0;           // not decoded, or not a number, or no rotation
  int out_of_order = 0;  // utime not after the one before
  std::int64_t last_utime = INT64_MIN;
};
using Tallies = std::map<std::string, Tally>;

std::FILE* ages = nullptr;  // of poses, ms, one a line

volatile std::sig_atomic_t stop_requested = 0;
void request_stop(int /*signal*/) { stop_requested = 1; }

bool is_transform(const double (&trans)[3], const double (&quat)[4]) {
  double norm = 0;
  for (const double q : quat) norm += q * q;
  return std::isfinite(trans[0] + trans[1] + trans[2]) && std::abs(norm - 1) < 1e-6;
}

bool makes_sense(const bot_core::pose_t& m) { return is_transform(m.pos, m.orientation); }
bool makes_sense(const bot_frames::update_t& m) { return is_transform(m.trans, m.quat) && !m.frame.empty(); }
bool makes_sense(const loopsift::loop_t& m) { return is_transform(m.T_i_j.trans, m.T_i_j.quat) && m.id >= 0; }
bool makes_sense(const loopsift::pose_t& m) { return is_transform(m.T_map_body.trans, m.T_map_body.quat); }
bool makes_sense(const loopsift::fragment_t& m) { return m.n >= 0 && m.chunk < m.chunk_count; }
bool makes_sense(const loopsift::graph_t& m) { return m.version > 0 && m.chunk < m.chunk_count; }
bool makes_sense(const loopsift::health_t& m) { return m.uptime_s >= 0 && m.n_latency > 0; }
bool makes_sense(const loopsift::correction_t& m) {
  return is_transform(m.T_map_odom.trans, m.T_map_odom.quat) && m.epoch > 0;
}

/// Decodes; false when that fails or the content is nonsense.
template <class Message>
bool check(const lcm_recv_buf_t& received, std::int64_t* utime) {
  Message message{};
  const int size = static_cast<int>(received.data_size);
  if (message.decode(received.data, 0, size) != size) return false;
  *utime = message.utime;
  return makes_sense(message);
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// How long ago the frame of a pose came in, by this host's clock.
void note_age(const lcm_recv_buf_t& received) {
  loopsift::pose_t message{};
  if (ages == nullptr || message.decode(received.data, 0, static_cast<int>(received.data_size)) < 0) return;
  const std::int64_t now_us = std::chrono::duration_cast<std::chrono::microseconds>(
                                  std::chrono::system_clock::now().time_since_epoch())
                                  .count();
  std::fprintf(ages, "%.3f\n", 1e-3 * static_cast<double>(now_us - message.captured_utime));
}

void receive(const lcm_recv_buf_t* received, const char* channel_name, void* user) {
  const std::string channel = channel_name;
  Tally& tally = (*static_cast<Tallies*>(user))[channel];
  std::int64_t utime = INT64_MIN;
  bool good = false;
  if (ends_with(channel, "LOOPSIFT_CORRECTION")) good = check<loopsift::correction_t>(*received, &utime);
  if (ends_with(channel, "LOOPSIFT_UPDATE")) good = check<bot_frames::update_t>(*received, &utime);
  if (ends_with(channel, "LOOPSIFT_LOOP")) good = check<loopsift::loop_t>(*received, &utime);
  if (ends_with(channel, "LOOPSIFT_FRAGMENT")) good = check<loopsift::fragment_t>(*received, &utime);
  if (ends_with(channel, "LOOPSIFT_GRAPH")) good = check<loopsift::graph_t>(*received, &utime);
  if (ends_with(channel, "LOOPSIFT_HEALTH")) good = check<loopsift::health_t>(*received, &utime);
  if (ends_with(channel, "LOOPSIFT_POSE")) {
    good = check<loopsift::pose_t>(*received, &utime);
    note_age(*received);
  } else if (ends_with(channel, "POSE") || ends_with(channel, "POSE_ODOM"))
    good = check<bot_core::pose_t>(*received, &utime);
  ++tally.count;
  if (!good) ++tally.bad;
  const bool many_of_one_time =
      ends_with(channel, "LOOP") || ends_with(channel, "FRAGMENT") || ends_with(channel, "GRAPH");
  if (utime <= tally.last_utime && !many_of_one_time) ++tally.out_of_order;
  tally.last_utime = utime;
}

void print_json(const Tallies& tallies) {
  const char* separator = "{";
  for (const auto& [channel, tally] : tallies) {
    std::printf("%s\"%s\": {\"count\": %d, \"bad\": %d, \"out_of_order\": %d}", separator, channel.c_str(),
                tally.count, tally.bad, tally.out_of_order);
    separator = ",\n ";
  }
  std::printf("%s}\n", tallies.empty() ? "{" : "");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: lcm_listen URL [AGES]\n");
    return 2;
  }
  lcm_t* lcm = lcm_create(argv[1]);
  if (lcm == nullptr) return 1;
  Tallies tallies;
  lcm_subscription_t* subscription = lcm_subscribe(lcm, ".*", receive, &tallies);
  lcm_subscription_set_queue_capacity(subscription, 10'000);
  std::signal(SIGTERM, request_stop);
  if (argc > 2) ages = std::fopen(argv[2], "w");
  std::printf("listening\n");
  std::fflush(stdout);
  constexpr int kQuiet_ms = 2000;  // after SIGTERM, this long without a message is the end
  while (lcm_handle_timeout(lcm, kQuiet_ms) != 0 || stop_requested == 0) {
  }
  lcm_destroy(lcm);
  if (ages != nullptr) std::fclose(ages);
  print_json(tallies);
  return 0;
}
