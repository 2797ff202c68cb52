// SPDX-License-Identifier: MIT
// A loop detector of another program: lcm_loop_finder URL TRUTH I_S J_S. Hears where the camera is, and says
// on LOOPSIFT_LOOP_IN how the moments I_S and J_S of the trajectory TRUTH lie to each other: rightly, a metre
// off, and in four forms that are no loop at all. Both must begin a fragment, so that the answers can be told
// apart. Exit 0 when the right loop was accepted, the wrong one was not, and the four were refused; 1 when
// that has not happened within three minutes.
#include <lcm/lcm.h>

#include <array>
#include <bot_core/pose_t.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <loopsift/health_t.hpp>
#include <loopsift/loop_in_t.hpp>
#include <loopsift/loop_t.hpp>
#include <vector>

#include "core/geometry/trajectory.hpp"
#include "firmware_app/publisher_messages.hpp"

namespace {

using namespace loopsift;
using Clock = std::chrono::steady_clock;
constexpr auto kLimit = std::chrono::seconds(180);
constexpr double kOff_m = 1.0, kSame_m = 0.01;
constexpr int kNoLoops = 4;

struct Finder {
  lcm_t* lcm = nullptr;
  loop_in_t right{}, wrong{};
  bool told = false, right_accepted = false, wrong_rejected = false;
  std::int64_t refused = 0;

  [[nodiscard]] bool satisfied() const { return right_accepted && wrong_rejected && refused >= kNoLoops; }
};

void send(lcm_t* lcm, const loop_in_t& message, int left_out = 0) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  lcm_publish(lcm, "LOOPSIFT_LOOP_IN", bytes.data(),
              static_cast<unsigned>(bytes.size()) - static_cast<unsigned>(left_out));
}

void tell(Finder* finder) {
  send(finder->lcm, finder->right, 8);  // cut off
  loop_in_t none = finder->right;
  none.T_i_j.quat[0] += 1;  // no rotation
  send(finder->lcm, none);
  none = finder->right;
  none.covariance[0] = -1;
  send(finder->lcm, none);
  none = finder->right;
  none.utime_j = -1;
  send(finder->lcm, none);
  send(finder->lcm, finder->right);
  send(finder->lcm, finder->wrong);
  finder->told = true;
}

double apart_m(const transform_t& a, const transform_t& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (a.trans[k] - b.trans[k]) * (a.trans[k] - b.trans[k]);
  return std::sqrt(sum);
}

template <class Message>
bool decode(const lcm_recv_buf_t& received, Message* message) {
  const int size = static_cast<int>(received.data_size);
  return message->decode(received.data, 0, size) == size;
}

void hear_pose(const lcm_recv_buf_t* /*received*/, const char* /*channel*/, void* user) {
  auto* finder = static_cast<Finder*>(user);
  if (!finder->told) tell(finder);
}

void hear_answer(const lcm_recv_buf_t* received, const char* /*channel*/, void* user) {
  auto* finder = static_cast<Finder*>(user);
  loop_t loop{};
  if (!decode(*received, &loop)) return;
  std::printf("loop %d, fragments %d and %d, %.3f m from the truth: %s (%s), DMP alone %.4f\n", loop.id,
              loop.fragment_i, loop.fragment_j, apart_m(loop.T_i_j, finder->right.T_i_j),
              loop.decision == loop_t::ACCEPTED ? "accepted" : "not accepted", loop.reason.c_str(),
              loop.single_dmp);
  if (apart_m(loop.T_i_j, finder->right.T_i_j) < kSame_m)
    finder->right_accepted = loop.decision == loop_t::ACCEPTED;
  if (apart_m(loop.T_i_j, finder->wrong.T_i_j) < kSame_m)
    finder->wrong_rejected = loop.decision != loop_t::ACCEPTED;
}

void hear_health(const lcm_recv_buf_t* received, const char* /*channel*/, void* user) {
  health_t health{};
  if (decode(*received, &health)) static_cast<Finder*>(user)->refused = health.commands_refused;
}

bool read_truth(char** argv, Finder* finder) {
  const auto truth = read_trajectory(argv[2]);
  const double i_s = std::atof(argv[3]), j_s = std::atof(argv[4]);
  Se3 T_w_i, T_w_j;
  if (!truth.ok() || !truth->at(i_s, 0.01, &T_w_i) || !truth->at(j_s, 0.01, &T_w_j)) return false;
  finder->right.utime_i = static_cast<std::int64_t>(1e6 * i_s);
  finder->right.utime_j = static_cast<std::int64_t>(1e6 * j_s);
  fill(&finder->right.T_i_j, T_w_i.inverse() * T_w_j);
  finder->wrong = finder->right;
  finder->wrong.T_i_j.trans[0] += kOff_m;
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  Finder finder;
  if (argc != 5 || !read_truth(argv, &finder)) {
    std::fprintf(stderr, "usage: lcm_loop_finder URL TRUTH I_S J_S\n");
    return 2;
  }
  finder.lcm = lcm_create(argv[1]);
  if (finder.lcm == nullptr) return 1;
  lcm_subscribe(finder.lcm, "POSE", hear_pose, &finder);
  lcm_subscribe(finder.lcm, "LOOPSIFT_LOOP", hear_answer, &finder);
  lcm_subscribe(finder.lcm, "LOOPSIFT_HEALTH", hear_health, &finder);
  std::printf("listening\n");
  std::fflush(stdout);
  const auto until = Clock::now() + kLimit;
  while (!finder.satisfied() && Clock::now() < until) lcm_handle_timeout(finder.lcm, 100);
  std::printf("right loop %s, wrong loop %s, %lld refused\n",
              finder.right_accepted ? "accepted" : "not accepted",
              finder.wrong_rejected ? "rejected" : "not rejected", static_cast<long long>(finder.refused));
  lcm_destroy(finder.lcm);
  return finder.satisfied() ? 0 : 1;
}
