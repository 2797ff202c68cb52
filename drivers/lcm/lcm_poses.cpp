// SPDX-License-Identifier: MIT
#include "drivers/lcm/lcm_poses.hpp"

#include <lcm/lcm.h>

#include <algorithm>
#include <bot_core/pose_t.hpp>
#include <cmath>
#include <thread>
#include <utility>

#include "drivers/lcm/lcm_clock.hpp"

namespace loopsift {
namespace {

constexpr int kHearTimeout_ms = 50;
constexpr double kSameLength = 0.01;  // a unit quaternion's length is within this of 1

class Receiver final : public LcmPoses {
 public:
  Receiver(lcm_t* lcm, const std::string& channel, std::int64_t offset_ns, Sink sink)
      : lcm_(lcm), offset_ns_(offset_ns), sink_(std::move(sink)) {
    const auto handler = [](const lcm_recv_buf_t* received, const char* /*channel*/, void* self) {
      static_cast<Receiver*>(self)->receive(*received);
    };
    lcm_subscribe(lcm_, channel.c_str(), handler, this);
    thread_ = std::thread([this] { hear(); });
  }
  ~Receiver() override {
    stopping_ = true;
    thread_.join();
    lcm_destroy(lcm_);
  }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  [[nodiscard]] std::int64_t bad() const override { return bad_; }

 private:
  void hear() {
    while (!stopping_)
      if (lcm_handle_timeout(lcm_, kHearTimeout_ms) < 0)  // a provider that is at its end
        std::this_thread::sleep_for(std::chrono::milliseconds(kHearTimeout_ms));
  }
  void receive(const lcm_recv_buf_t& received) {
    std::int64_t utime_us = 0;
    Se3 T_local_body;
    if (!parse_pose(received.data, received.data_size, &utime_us, &T_local_body)) {
      bad_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    sink_(utime_us * 1000 + offset_ns_, T_local_body);
  }

  lcm_t* lcm_;
  const std::int64_t offset_ns_;
  const Sink sink_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::int64_t> bad_{0};
  std::thread thread_;
};

}  // namespace

bool parse_pose(const void* bytes, std::size_t size, std::int64_t* utime_us, Se3* T_local_body) {
  bot_core::pose_t message{};
  const int expected = message.getEncodedSize();
  if (size != static_cast<std::size_t>(expected) || message.decode(bytes, 0, expected) != expected)
    return false;
  if (message.utime < 0 || message.utime > kLatestUtime_us) return false;
  const double* q = message.orientation;
  const Eigen::Quaterniond orientation(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d position(message.pos[0], message.pos[1], message.pos[2]);
  if (!position.allFinite() || !(std::abs(orientation.norm() - 1.0) < kSameLength)) return false;
  *utime_us = message.utime;
  *T_local_body = Se3(orientation, position);
  return true;
}

Expected<std::unique_ptr<LcmPoses>> LcmPoses::open(const std::string& channel, const LcmInOptions& options,
                                                   Sink sink) {
  lcm_t* lcm = channel.empty() ? nullptr : lcm_create(options.url.c_str());
  if (channel.empty())
    return Error{ErrorCode::kUsage, "run.odometry: lcm: names no channel; write lcm:CHANNEL"};
  if (lcm == nullptr)
    return Error{ErrorCode::kIo, "lcm:" + channel + ": LCM cannot be opened at " + options.url +
                                     " (lcm_in.url); for udpm:// a multicast route is needed: ip link set lo "
                                     "multicast on; ip route add 224.0.0.0/4 dev lo"};
  const std::int64_t offset_ns = options.host_clock ? wall_to_monotonic_ns() : 0;
  return std::unique_ptr<LcmPoses>(std::make_unique<Receiver>(lcm, channel, offset_ns, std::move(sink)));
}

}  // namespace loopsift
