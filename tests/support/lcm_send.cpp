// SPDX-License-Identifier: MIT
// The publisher alone as a process of its own: lcm_send URL sends 60 poses at 200 Hz, after each tenth a
// correction, and 30 loop decisions.
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "firmware_app/publisher.hpp"

int main(int argc, char** argv) {
  using namespace loopsift;
  if (argc != 2) {
    std::fprintf(stderr, "usage: lcm_send URL\n");
    return 2;
  }
  LcmSettings settings;
  settings.url = argv[1];
  Arena measuring;
  { const Publisher publisher(settings, measuring); }
  Arena arena(measuring.used_bytes());
  Publisher publisher(settings, arena);
  if (const Status started = publisher.start(); !started.ok()) {
    std::fprintf(stderr, "%s\n", started.error().message.c_str());
    return 1;
  }
  const auto correction = std::make_unique<CorrectionRecord>();
  bool queued = true;
  for (int i = 1; i <= 60; ++i) {
    const std::int64_t now_ns = std::int64_t{i} * 5'000'000;
    PoseRecord pose;
    pose.timestamp_ns = now_ns;
    pose.T_odom_camera = Se3(Eigen::Matrix3d::Identity(), {0, 0, 0.01 * i});
    queued = publisher.publish(pose) && queued;
    if (i % 10 == 0) {
      correction->timestamp_ns = now_ns;
      correction->epoch = i / 10;
      queued = publisher.publish(*correction) && queued;
    }
    if (i % 2 == 0) {
      LoopRecord loop;
      loop.timestamp_ns = now_ns;
      loop.id = i / 2;
      queued = publisher.publish(loop) && queued;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  publisher.stop();
  return queued && publisher.failed() == 0 ? 0 : 1;
}
