// SPDX-License-Identifier: MIT
#include "firmware_app/driver_options.hpp"

namespace loopsift {
namespace {

OptionSection openni2_section(OpenNi2Options& o) {
  constexpr OptionRange kDeviceUnits{0, 65535};
  return {
      "openni2",
      "Cameras through OpenNI2 (docs/drivers.md). The image size is camera.width and height, or 640 x 480.",
      {
          {"rate_hz", &o.rate_hz, "frames per second of both images", {1, 240}},
          {"fine_depth", &o.fine_depth, "depth in steps of 0.1 mm, up to 6.5 m; else of 1 mm"},
          {"color", &o.color, "read the colour camera as well"},
          {"registration", &o.registration, "move depth to where the colour camera sees it, if it can"},
          {"frame_sync", &o.frame_sync, "take depth and colour at the same time, if it can"},
          {"auto_exposure", &o.auto_exposure, "of the colour camera"},
          {"auto_white_balance", &o.auto_white_balance, "of the colour camera"},
          {"exposure", &o.exposure, "without auto_exposure; 0: as the device has it", kDeviceUnits},
          {"gain", &o.gain, "without auto_exposure; 0: as the device has it", kDeviceUnits},
          {"host_time", &o.host_time, "time stamps on this computer's clock; false: as the camera has them"},
          {"record_path", &o.record_path, "also record what is read to this .oni file; empty: do not"},
      }};
}

OptionSection v4l2_section(V4l2Options& o) {
  constexpr OptionRange kPixels{0, 16384};
  return {"v4l2",
          "Cameras through V4L2 (docs/drivers.md). A source's URI may set each for its own device, as in "
          "v4l2:/dev/video2?format=YUYV&width=1280&height=720.",
          {
              {"format", &o.format,
               "four characters, as Z16 or YUYV; empty: the first that is read, depth first"},
              {"width", &o.width, "pixels; 0: as camera.width, or 640", kPixels},
              {"height", &o.height, "pixels; 0: as camera.height, or 480", kPixels},
              {"rate_hz", &o.rate_hz, "frames per second", {1, V4l2Options::kHighestRateHz}},
              {"buffers", &o.buffers, "images that the kernel keeps", {2, V4l2Options::kMostBuffers}},
              {"controls", &o.controls, "set in this order before the first frame, as [\"gain=16\"]"},
          }};
}

OptionSection libcamera_section(LibcameraOptions& o) {
  constexpr OptionRange kPixels{16, 16384};
  return {"libcamera",
          "Colour cameras through libcamera (docs/drivers.md).",
          {
              {"format", &o.format, "as BGR888, NV12 or YUYV; empty: the first that is read"},
              {"width", &o.width, "pixels; the nearest that the camera has is taken", kPixels},
              {"height", &o.height, "pixels; the nearest that the camera has is taken", kPixels},
              {"rate_hz", &o.rate_hz, "frames per second, where the camera lets it be chosen", {1, 1000}},
              {"buffers", &o.buffers, "images on their way", {2, LibcameraOptions::kMostBuffers}},
          }};
}

OptionSection lcm_in_section(LcmInOptions& o) {
  return {"lcm_in",
          "Images and odometry of other programs, over LCM (docs/drivers.md).",
          {
              {"url", &o.url, "LCM provider; whole images need a large receive buffer"},
              {"open_timeout_s", &o.open_timeout_s, "for the first message", {0.01, 1e6}},
              {"rate_hz", &o.rate_hz, "of the images; what source.stall_periods counts", {0.01, 1000}},
              {"host_clock", &o.host_clock,
               "utime is this computer's wall clock: turn it into the clock of its cameras"},
          }};
}

}  // namespace

OptionTable driver_sections(SourceOptions& options) {
  return {openni2_section(options.openni2), v4l2_section(options.v4l2), libcamera_section(options.libcamera),
          lcm_in_section(options.lcm_in)};
}

OptionSection lcm_odometry_section(LcmOdometryOptions& o) {
  constexpr OptionRange kMetres{-100, 100}, kRadians{-7, 7};
  return {"odometry.lcm",
          "Odometry over LCM: bot_core.pose_t of the body that carries the camera. Gaps and noise: "
          "odometry.file.",
          {
              {"wait_ms", &o.stream.wait_ms, "of a frame for the pose after it, at most", {0, 1000}},
              {"max_speed_m_per_s",
               &o.stream.max_speed_m_per_s,
               "a faster motion is a jump: a new piece of trajectory",
               {0.01, 1e6}},
              {"camera_x_m", &o.camera_x_m, "where the camera sits on the body, X forward", kMetres},
              {"camera_y_m", &o.camera_y_m, "Y left", kMetres},
              {"camera_z_m", &o.camera_z_m, "Z up", kMetres},
              {"camera_roll_rad", &o.camera_roll_rad, "how it is turned: first about X", kRadians},
              {"camera_pitch_rad", &o.camera_pitch_rad, "then about Y", kRadians},
              {"camera_yaw_rad", &o.camera_yaw_rad, "then about Z", kRadians},
          }};
}

}  // namespace loopsift
