// SPDX-License-Identifier: MIT
#include "drivers/openni2/camera.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "drivers/openni2/modes.hpp"

namespace loopsift::openni2 {
namespace {

constexpr int kUsualWidth = 640, kUsualHeight = 480;

bool is_recording_path(const std::string& address) {
  return std::filesystem::path(address).extension() == ".oni";
}

Error failure(const std::string& what, const std::string& hint) {
  const std::string why = last_error();
  return {ErrorCode::kIo, what + (why.empty() ? "" : ": " + why) + (hint.empty() ? "" : "; " + hint)};
}

bool any_device_is_there() {
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  return devices.getSize() > 0;
}

Error no_device() {
  return {ErrorCode::kNotFound, "no such device is connected; `loopsift-tool devices` lists those that are"};
}

/// What OpenNI2 itself does not tell apart.
Status check_recording(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, path + ": no such recording, or no right to read it"};
  char magic[4] = {};
  file.read(magic, sizeof magic);
  if (file && std::memcmp(magic, "NI10", sizeof magic) == 0) return {};
  return Error{ErrorCode::kFormat, path + ": is no OpenNI2 recording (.oni): its first bytes are not NI10"};
}

/// The pinhole of a field of view; focal lengths of 0 where that is not known.
PinholeCamera camera_of(const openni::VideoStream& video, int width, int height) {
  const auto focal = [](int pixels, float fov_rad) {
    return fov_rad > 0 ? 0.5F * static_cast<float>(pixels) / std::tan(0.5F * fov_rad) : 0.0F;
  };
  return {width,
          height,
          focal(width, video.getHorizontalFieldOfView()),
          focal(height, video.getVerticalFieldOfView()),
          0.5F * static_cast<float>(width - 1),
          0.5F * static_cast<float>(height - 1)};
}

void override_with(float value, float* target) {
  if (value != 0) *target = value;
}

/// `path`, or with -2, -3, … before its ending where such files are there: none is written over.
std::string free_path(const std::filesystem::path& path) {
  std::filesystem::path candidate = path;
  for (int number = 2; std::filesystem::exists(candidate); ++number) {
    candidate = path;
    candidate.replace_filename(path.stem().string() + "-" + std::to_string(number) +
                               path.extension().string());
  }
  return candidate.string();
}

}  // namespace

Expected<std::unique_ptr<Camera>> Camera::open(const std::string& address, const SourceOptions& options) {
  std::unique_ptr<Camera> camera(new Camera());
  if (!camera->session_.status()) return camera->session_.status().error();
  const bool color = options.want_color && options.openni2.color;
  Status status = camera->open_device(address);
  if (status) status = camera->open_depth(options);
  if (status && color) status = camera->open_color(options);
  if (status) status = camera->describe(options);
  if (status && !options.openni2.record_path.empty()) {
    status = camera->start_recorder(options.openni2.record_path);
  }
  if (status) status = camera->start();
  if (!status) return Error{status.error().code, camera->name_ + ": " + status.error().message};
  return camera;
}

Camera::~Camera() {
  recorder_.destroy();
  if (depth_.video.isValid()) depth_.video.stop();
  if (color_.video.isValid()) color_.video.stop();
  if (is_recording() || (watch_ != nullptr && watch_->is_gone())) Session::keep();
}

Status Camera::open_device(const std::string& address) {
  name_ = "openni2:" + address;
  const bool recording = is_recording_path(address);
  if (recording) {
    if (Status usable = check_recording(address); !usable) return usable;
  }
  if (address.empty() && !any_device_is_there()) return no_device();
  const openni::Status opened = device_.open(address.empty() ? openni::ANY_DEVICE : address.c_str());
  if (opened != openni::STATUS_OK && recording) {
    return Error{ErrorCode::kFormat,
                 "OpenNI2 cannot read it: it is cut off, or whoever recorded it did not close it"};
  }
  if (opened == openni::STATUS_NO_DEVICE) return no_device();
  if (opened != openni::STATUS_OK) {
    return failure("the device cannot be opened",
                   "is another program using it, or is there no right to it (udev rules, group video)?");
  }
  const openni::DeviceInfo& device = device_.getDeviceInfo();
  watch_ = std::make_unique<DeviceWatch>(device.getUri());
  if (!recording) {
    name_ =
        std::string("openni2 ") + device.getVendor() + " " + device.getName() + " (" + device.getUri() + ")";
    return {};
  }
  openni::PlaybackControl* playback = device_.getPlaybackControl();
  if (playback == nullptr ||
      playback->setSpeed(-1) != openni::STATUS_OK ||  // frame by frame, none is skipped
      playback->setRepeatEnabled(false) != openni::STATUS_OK) {
    return failure("cannot be played frame by frame", "");
  }
  return {};
}

Status Camera::open_depth(const SourceOptions& options) {
  if (!device_.hasSensor(openni::SENSOR_DEPTH)) return Error{ErrorCode::kUnsupported, "has no depth images"};
  if (depth_.video.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK)
    return failure("no depth stream", "");
  if (is_recording()) {
    depth_.frames = device_.getPlaybackControl()->getNumberOfFrames(depth_.video);
  } else {
    const int width = options.camera.width != 0 ? options.camera.width : kUsualWidth;
    const int height = options.camera.height != 0 ? options.camera.height : kUsualHeight;
    const auto mode = choose_depth_mode(depth_.video.getSensorInfo(), width, height, options.openni2);
    if (!mode) return mode.error();
    if (depth_.video.setVideoMode(*mode) != openni::STATUS_OK)
      return failure("refuses the depth mode " + to_text(*mode), "");
    (void)depth_.video.setMirroringEnabled(false);  // what it does in the end is asked for below
  }
  depth_.mode = depth_.video.getVideoMode();
  depth_.mirrored = depth_.video.getMirroringEnabled();
  if (depth_unit_m(depth_.mode.getPixelFormat()) > 0) return {};
  return Error{ErrorCode::kUnsupported,
               "gives depth as " + to_text(depth_.mode) + ", which is not read; 1 mm and 0.1 mm are"};
}

Status Camera::open_color(const SourceOptions& options) {
  if (!device_.hasSensor(openni::SENSOR_COLOR)) return {};
  if (color_.video.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK)
    return failure("no colour stream", "without colour: openni2.color = false");
  if (is_recording()) {
    color_.frames = device_.getPlaybackControl()->getNumberOfFrames(color_.video);
  } else {
    const auto mode = choose_color_mode(color_.video.getSensorInfo(), depth_.mode.getResolutionX(),
                                        depth_.mode.getResolutionY(), options.openni2);
    if (!mode) return mode.error();
    if (color_.video.setVideoMode(*mode) != openni::STATUS_OK)
      return failure("refuses the colour mode " + to_text(*mode), "");
    (void)color_.video.setMirroringEnabled(false);
    set_up_color(options.openni2);
    set_up_both(options.openni2);
  }
  color_.mode = color_.video.getVideoMode();
  color_.mirrored = color_.video.getMirroringEnabled();
  if (is_color(color_.mode.getPixelFormat())) return {};
  return Error{ErrorCode::kUnsupported,
               "gives colour as " + to_text(color_.mode) +
                   ", which is not read; RGB and grey are; without colour: openni2.color = false"};
}

// What a device does not know it refuses; that is as good as its own way.
void Camera::set_up_color(const OpenNi2Options& options) {
  openni::CameraSettings* settings = color_.video.getCameraSettings();
  if (settings == nullptr) return;
  (void)settings->setAutoExposureEnabled(options.auto_exposure);
  (void)settings->setAutoWhiteBalanceEnabled(options.auto_white_balance);
  if (options.auto_exposure) return;
  if (options.exposure != 0) (void)settings->setExposure(options.exposure);
  if (options.gain != 0) (void)settings->setGain(options.gain);
}

void Camera::set_up_both(const OpenNi2Options& options) {
  constexpr auto kToColor = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  const bool can_register = device_.isImageRegistrationModeSupported(kToColor);
  if (options.registration && can_register &&
      device_.setImageRegistrationMode(kToColor) == openni::STATUS_OK) {
    extras_ += ", registered";
  } else if (can_register) {
    (void)device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_OFF);
  }
  if (options.frame_sync && device_.setDepthColorSyncEnabled(true) == openni::STATUS_OK)
    extras_ += ", synchronised";
}

Status Camera::describe(const SourceOptions& options) {
  const int width = depth_.mode.getResolutionX(), height = depth_.mode.getResolutionY();
  info_.camera = camera_of(depth_.video, width, height);
  override_with(options.camera.fx, &info_.camera.fx);
  override_with(options.camera.fy, &info_.camera.fy);
  override_with(options.camera.cx, &info_.camera.cx);
  override_with(options.camera.cy, &info_.camera.cy);
  if (!info_.camera.is_valid()) {
    return Error{ErrorCode::kFormat, "its field of view is not known: give camera.fx, fy, cx and cy"};
  }
  const PinholeCamera& known = options.camera;
  if ((known.width != 0 && known.width != width) || (known.height != 0 && known.height != height)) {
    return Error{ErrorCode::kFormat, "its depth is " + to_text(depth_.mode) +
                                         ", but camera.width and height are " + std::to_string(known.width) +
                                         "x" + std::to_string(known.height)};
  }
  info_.depth_unit_m =
      options.depth_scale > 0 ? 1.0 / options.depth_scale : depth_unit_m(depth_.mode.getPixelFormat());
  info_.nominal_rate_hz = depth_.mode.getFps() > 0 ? depth_.mode.getFps() : info_.nominal_rate_hz;
  info_.live = !is_recording();
  info_.frame_count = depth_.frames;
  info_.description = name_ + ", depth " + to_text(depth_.mode);
  if (!has_color()) return {};
  info_.color_width = color_.mode.getResolutionX();
  info_.color_height = color_.mode.getResolutionY();
  info_.description += ", colour " + to_text(color_.mode) + extras_;
  return {};
}

Status Camera::start() {
  if (depth_.video.start() != openni::STATUS_OK) return failure("the depth stream does not start", "");
  if (has_color() && color_.video.start() != openni::STATUS_OK)
    return failure("the colour stream does not start", "");
  return {};
}

Status Camera::start_recorder(const std::string& path) {
  if (is_recording())
    return Error{ErrorCode::kUsage, "openni2.record_path needs a camera; this is a recording"};
  const std::string file = free_path(path);
  const bool recording = recorder_.create(file.c_str()) == openni::STATUS_OK &&
                         recorder_.attach(depth_.video) == openni::STATUS_OK &&
                         (!has_color() || recorder_.attach(color_.video) == openni::STATUS_OK) &&
                         recorder_.start() == openni::STATUS_OK;
  if (recording) return {};
  return failure("openni2.record_path: cannot record to " + file, "");
}

}  // namespace loopsift::openni2
