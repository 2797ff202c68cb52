// SPDX-License-Identifier: MIT
// What the test camera is told: a file of `name value` lines, named by the environment variable
// LOOPSIFT_TEST_CAMERA, and read again all the time, so that a test can pull the plug.
#pragma once
#include <optional>
#include <string>

namespace loopsift::test {

constexpr const char* kControlVariable = "LOOPSIFT_TEST_CAMERA";

struct CameraControl {
  std::string film = "none";     ///< path, without blanks; see film.hpp
  bool plugged = true;           ///< false: the device goes away, or is not there
  bool busy = false;             ///< the device cannot be opened
  bool silent = false;           ///< there, but no frames come
  bool repeat = false;           ///< the film begins anew at its end, its time going on
  bool unplug_at_end = false;    ///< the device goes away after the film's last frame; not with repeat
  bool can_register = true;      ///< depth can be moved to the colour camera
  bool can_sync = true;          ///< depth and colour can be taken together
  bool mirrored = false;         ///< images are mirrored, and the device cannot be told otherwise
  double field_of_view_rad = 1;  ///< horizontal, of both cameras; 0: not known
  double rate_hz = 30;           ///< at which frames are played, whatever their time stamps say
  double color_delay_ms = 0;     ///< device time of a colour image after its depth image
  int color_every = 1;           ///< only each of so many frames has a colour image
  double time_offset_s = 0;      ///< added to every device time, from the next image on

  /// Unknown names are left out: a test that writes the file may be halfway.
  /// Nothing without the file.
  [[nodiscard]] static std::optional<CameraControl> find(const std::string& path);
  /// By the control file that the environment names.
  [[nodiscard]] static std::optional<CameraControl> find();
  [[nodiscard]] static CameraControl read() { return find().value_or(CameraControl{}); }
  /// Replaces the file in one step.
  void write(const std::string& path) const;
};

}  // namespace loopsift::test
