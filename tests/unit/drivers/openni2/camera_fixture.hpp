// SPDX-License-Identifier: MIT
// The test camera, ready, and what a reader sees of it.
//
// ctest runs each test in a process of its own. The whole program at once may crash or hang inside
// OpenNI2 2.2, which does not stand being opened many times in one process (drivers/openni2/session.hpp): run
// one test of it with --gtest_filter.
#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/steady_time.hpp"
#include "drivers/openni2/openni2_source.hpp"
#include "tests/support/openni2_plugin/test_camera.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift::test {

constexpr std::int64_t kLimitNs = 60'000'000'000;  // for anything that has to happen

class CameraFixture : public ::testing::Test {
 protected:
  struct Seen {
    std::int64_t timestamp_ns = 0, captured_ns = 0, sequence = 0;
    std::vector<std::uint16_t> depth;
    std::vector<Rgb8> color;
    int width = 0, height = 0;
  };

  void SetUp() override {
    if (!TestCamera::install()) GTEST_SKIP() << TestCamera::kNotAllowed;
  }

  /// What the camera plays, again and again, from the next opening on.
  void film(int frames, int width, int height, bool with_color = true) {
    const std::string path = camera.folder() / "film";
    write_drawn_film(path, frames, width, height, with_color);
    camera.control.film = path;
    camera.control.repeat = true;
    camera.apply();
  }
  [[nodiscard]] Expected<std::unique_ptr<FrameSource>> open(const std::string& address = "") const {
    return open_openni2(address, options);
  }
  /// A camera that was just plugged in.
  [[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_when_there() const {
    const std::int64_t limit_ns = steady_now_ns() + kLimitNs;
    auto source = open();
    while (!source.ok() && steady_now_ns() < limit_ns) source = open();
    return source;
  }

  /// The next status that is no kTimeout.
  [[nodiscard]] static ReadStatus read(FrameSource& source, RawFrame& frame) {
    const std::int64_t limit_ns = steady_now_ns() + kLimitNs;
    ReadStatus status = ReadStatus::kTimeout;
    while (status == ReadStatus::kTimeout && steady_now_ns() < limit_ns) status = source.read(frame, 100);
    return status;
  }
  [[nodiscard]] static Seen see(const RawFrame& frame) {
    Seen seen{frame.timestamp_ns, frame.captured_ns, frame.sequence, {}, {},
              frame.depth.width,  frame.depth.height};
    seen.depth.assign(frame.depth.data, frame.depth.data + frame.depth.size());
    if (!frame.color.empty()) seen.color.assign(frame.color.data, frame.color.data + frame.color.size());
    return seen;
  }
  /// `count` frames; fewer where the source ends before.
  [[nodiscard]] static std::vector<Seen> read_frames(FrameSource& source, int count) {
    FrameBuffers buffers(source.info());
    std::vector<Seen> frames;
    while (static_cast<int>(frames.size()) < count) {
      const ReadStatus status = read(source, buffers.frame);
      if (status != ReadStatus::kFrame) {
        ADD_FAILURE() << "status " << static_cast<int>(status) << " " << source.message();
        break;
      }
      frames.push_back(see(buffers.frame));
    }
    return frames;
  }
  /// Whether a frame's colour is, to the bit, the one drawn for this seed.
  [[nodiscard]] static bool is_color(const Seen& frame, int seed) {
    ColorImage drawn = make_color(frame.width, frame.height, seed);
    const ImageView<const Rgb8> seen(frame.color.data(), frame.color.empty() ? 0 : frame.width, frame.height);
    return largest_difference(drawn.view(), seen) == 0;
  }

  TestCamera camera;
  SourceOptions options;
};

}  // namespace loopsift::test
