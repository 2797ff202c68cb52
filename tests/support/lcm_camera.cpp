// SPDX-License-Identifier: MIT
// A camera of another program: lcm_camera URL BURSTS FRAMES PAUSE_MS renders FRAMES images of a walk through
// a room and sends them at 30 Hz, BURSTS times with pauses between, on CAMERA (bot_core.images_t) and, just
// after each image, where it was on BODY (bot_core.pose_t).
#include <lcm/lcm.h>

#include <bot_core/pose_t.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "core/geometry/body_axes.hpp"
#include "drivers/synth/synth_sequence.hpp"
#include "tests/support/lcm_images.hpp"

namespace {

using namespace loopsift;
using Clock = std::chrono::steady_clock;
constexpr int kWidth = 160, kHeight = 120;

std::int64_t wall_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

bot_core::images_t render(const SequenceRenderer& renderer, std::size_t k) {
  std::vector<std::uint16_t> depth(kWidth * kHeight);
  std::vector<Rgb8> color(depth.size());
  RenderedFrame scratch;
  renderer.render(k, &scratch, {depth.data(), kWidth, kHeight}, {color.data(), kWidth, kHeight});
  bot_core::images_t message = test::images(0, kWidth, kHeight, 0, false);
  std::memcpy(message.images[1].data.data(), depth.data(), 2 * depth.size());
  std::memcpy(message.images[0].data.data(), color.data(), 3 * color.size());
  return message;
}

bot_core::pose_t body_pose(const Se3& T_world_camera, std::int64_t utime_us) {
  const Eigen::Matrix3d R = camera_to_body_axes();
  const Eigen::Vector3d t = R * T_world_camera.translation();
  const Eigen::Quaterniond q(Eigen::Matrix3d(R * T_world_camera.rotation() * R.transpose()));
  bot_core::pose_t message{};
  message.utime = utime_us;
  for (int k = 0; k < 3; ++k) message.pos[k] = t[k];
  message.orientation[0] = q.w();
  message.orientation[1] = q.x();
  message.orientation[2] = q.y();
  message.orientation[3] = q.z();
  return message;
}

template <class Message>
bool send(lcm_t* lcm, const char* channel, const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return lcm_publish(lcm, channel, bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: lcm_camera URL BURSTS FRAMES PAUSE_MS\n");
    return 2;
  }
  const int bursts = std::atoi(argv[2]), pause_ms = std::atoi(argv[4]);
  const auto frames = static_cast<std::size_t>(std::atoi(argv[3]));
  const SourceOptions plain;
  const auto sequence = make_synth_sequence("room?width=160&height=120", plain);
  const auto renderer = SequenceRenderer::create(*sequence);
  lcm_t* lcm = lcm_create(argv[1]);
  if (!renderer.ok() || lcm == nullptr) return 1;
  std::vector<bot_core::images_t> images;
  for (std::size_t k = 0; k < frames; ++k) images.push_back(render(**renderer, k));
  bool sent = true;
  for (int burst = 0; burst < bursts; ++burst) {
    for (std::size_t k = 0; k < frames; ++k) {
      const auto due = Clock::now() + std::chrono::microseconds(33'333);
      images[k].utime = wall_us();
      sent = send(lcm, "CAMERA", images[k]) && sent;
      const Se3& T = sequence->trajectory.poses[k].T_world_camera;
      sent = send(lcm, "BODY", body_pose(T, images[k].utime)) && sent;
      std::this_thread::sleep_until(due);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
  }
  lcm_destroy(lcm);
  return sent ? 0 : 1;
}
