// SPDX-License-Identifier: MIT
#include "drivers/replay/calibration.hpp"

#include "core/base/text_file.hpp"
#include "drivers/image_limits.hpp"

namespace loopsift {
namespace {

constexpr const char* kNames = "fx fy cx cy width height depth_scale";

Status set_value(const TextFile& file, Calibration* calibration) {
  if (file.words().size() != 2)
    return file.error(std::string("expected `name value`, the name one of ") + kNames);
  const std::string name(file.words()[0]), word(file.words()[1]);
  double value = 0;
  if (!parse_number(word, &value)) return file.error("'" + word + "' is not a number");
  PinholeCamera& camera = calibration->camera;
  const bool is_size = name == "width" || name == "height", is_center = name == "cx" || name == "cy";
  if (value <= 0 && !is_center) return file.error(name + " must be greater than zero, not " + word);
  if (is_size && (value != static_cast<int>(value) || value > kLargestSide)) {
    return file.error(name + " must be a whole number of pixels, at most " + std::to_string(kLargestSide) +
                      ", not " + word);
  }
  if (name == "fx")
    camera.fx = static_cast<float>(value);
  else if (name == "fy")
    camera.fy = static_cast<float>(value);
  else if (name == "cx")
    camera.cx = static_cast<float>(value);
  else if (name == "cy")
    camera.cy = static_cast<float>(value);
  else if (name == "width")
    camera.width = static_cast<int>(value);
  else if (name == "height")
    camera.height = static_cast<int>(value);
  else if (name == "depth_scale")
    calibration->depth_scale = value;
  else
    return file.error("unknown name '" + name + "'; known are " + kNames);
  return {};
}

Status read_camera_file(const std::string& path, Calibration* calibration) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error().code == ErrorCode::kNotFound ? Status() : Status(file.error());
  while (file->next()) {
    const Status status = set_value(*file, calibration);
    if (!status) return status;
  }
  return {};
}

template <class T>
void override_with(T value, T* target) {
  if (value != T{}) *target = value;
}

}  // namespace

Expected<Calibration> resolve_calibration(const Calibration& defaults, const std::string& folder,
                                          const SourceOptions& options) {
  Calibration calibration = defaults;
  const Status status = read_camera_file(folder + "/camera.txt", &calibration);
  if (!status) return status.error();
  override_with(options.camera.width, &calibration.camera.width);
  override_with(options.camera.height, &calibration.camera.height);
  override_with(options.camera.fx, &calibration.camera.fx);
  override_with(options.camera.fy, &calibration.camera.fy);
  override_with(options.camera.cx, &calibration.camera.cx);
  override_with(options.camera.cy, &calibration.camera.cy);
  override_with(options.depth_scale, &calibration.depth_scale);
  if (!(calibration.depth_scale > 0)) {
    return Error{ErrorCode::kUsage, "the depth scale must be greater than zero raw units per metre, not " +
                                        std::to_string(calibration.depth_scale)};
  }
  return calibration;
}

Status fit_to_image(const std::string& folder, const std::string& image, int width, int height,
                    PinholeCamera* camera) {
  override_with(camera->width == 0 ? width : 0, &camera->width);
  override_with(camera->height == 0 ? height : 0, &camera->height);
  if (camera->width != width || camera->height != height) {
    const auto size = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
    return Error{ErrorCode::kFormat, image + " is " + size(width, height) + ", but the camera is known for " +
                                         size(camera->width, camera->height) + ": give " + kNames + " in " +
                                         folder + "/camera.txt"};
  }
  if (camera->is_valid()) return {};
  return Error{ErrorCode::kFormat,
               folder + ": no usable intrinsics are known: give " + kNames + " in " + folder + "/camera.txt"};
}

}  // namespace loopsift
