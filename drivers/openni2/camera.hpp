// SPDX-License-Identifier: MIT
// A device or recording that OpenNI2 has open, set up as the options say, its streams running. Set-up only;
// allocates.
#pragma once
#include <openni2/OpenNI.h>

#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/openni2/session.hpp"

namespace loopsift::openni2 {

/// One image stream, and what it delivers.
struct Stream {
  openni::VideoStream video;
  openni::VideoMode mode;
  bool mirrored = false;
  int frames = -1;  ///< in a recording; −1 of a device
};

/// Destruction stops all streams before it closes any, as OpenNI2 wants it.
class Camera {
 public:
  /// Errors as open_openni2().
  [[nodiscard]] static Expected<std::unique_ptr<Camera>> open(const std::string& address,
                                                              const SourceOptions& options);
  ~Camera();
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  [[nodiscard]] const SourceInfo& info() const { return info_; }
  [[nodiscard]] bool is_recording() const { return device_.isValid() && device_.isFile(); }
  [[nodiscard]] bool has_color() const { return color_.video.isValid(); }
  [[nodiscard]] Stream& depth() { return depth_; }
  [[nodiscard]] Stream& color() { return color_; }
  [[nodiscard]] const DeviceWatch& watch() const { return *watch_; }

 private:
  Camera() = default;
  [[nodiscard]] Status open_device(const std::string& address);
  [[nodiscard]] Status open_depth(const SourceOptions& options);
  [[nodiscard]] Status open_color(const SourceOptions& options);
  void set_up_color(const OpenNi2Options& options);
  void set_up_both(const OpenNi2Options& options);
  [[nodiscard]] Status describe(const SourceOptions& options);
  [[nodiscard]] Status start_recorder(const std::string& path);
  [[nodiscard]] Status start();

  Session session_;
  openni::Device device_;
  std::unique_ptr<DeviceWatch> watch_;
  Stream depth_, color_;
  openni::Recorder recorder_;
  std::string name_, extras_;
  SourceInfo info_;
};

}  // namespace loopsift::openni2
