// SPDX-License-Identifier: MIT
// A camera for tests below OpenNI2's own interface: the real library drives a plugin of ours as it drives a
// Kinect's. Throws std::runtime_error when a file cannot be written.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/frame_source.hpp"
#include "tests/support/openni2_plugin/control.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift::test {

/// Writes the next `frames` frames of a source as a film for the camera; fewer where it ends. All have
/// colour when the source has. A pixel without depth is 0, as OpenNI2 has it, also where the source says
/// 65535. Returns how many were written.
int write_film(FrameSource& source, int frames, const std::string& path);
/// The images that make_depth() and make_color() draw for the seeds 0, 1, …, at 30 Hz from `first_us` on.
void write_drawn_film(const std::string& path, int frames, int width, int height, bool with_color = true,
                      std::int64_t first_us = 1'000'000);

/// The one camera of this process and its children, plugged in.
class TestCamera {
 public:
  /// Gives this process a private view of the file system in which OpenNI2's settings name the plugin. Call
  /// it before any thread is started and before OpenNI2. False where that is not allowed: skip the test,
  /// saying so (kNotAllowed).
  [[nodiscard]] static bool install();
  static constexpr const char* kNotAllowed =
      "a mount namespace of one's own (unshare -m) is not allowed here, so OpenNI2 cannot be shown the test "
      "camera";

  TestCamera();
  TestCamera(const TestCamera&) = delete;
  TestCamera& operator=(const TestCamera&) = delete;

  CameraControl control;
  /// Tells the camera what `control` says now; it hears within some 30 ms. What concerns a device's making
  /// (film, modes, field of view) holds for the next time that it is opened.
  void apply() const { control.write(control_path_); }
  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
  std::string control_path_;
};

}  // namespace loopsift::test
