// SPDX-License-Identifier: MIT
#include "drivers/assemble_source.hpp"

#include "drivers/calibration/calibrated_source.hpp"
#include "drivers/replay/image_file.hpp"

namespace loopsift {
namespace {

template <class T>
void fill_in(T value, T* target) {
  if (*target == T{}) *target = value;
}

Expected<std::vector<std::uint16_t>> read_factors(const std::string& path) {
  if (path.empty()) return std::vector<std::uint16_t>();
  const auto size = read_image_size(path);
  if (!size) return size.error();
  std::vector<std::uint16_t> factors(static_cast<std::size_t>(size->width) *
                                     static_cast<std::size_t>(size->height));
  ImageReader reader(*size, {0, 0});
  if (const char* problem = reader.read_depth(path, {factors.data(), size->width, size->height}))
    return Error{ErrorCode::kFormat, path + ": " + problem};
  return factors;
}

}  // namespace

SourceOptions depth_options(const SourceOptions& options) {
  SourceOptions result = options;
  const PinholeCamera& from = options.calibration.depth.camera;
  fill_in(from.width, &result.camera.width);
  fill_in(from.height, &result.camera.height);
  fill_in(from.fx, &result.camera.fx);
  fill_in(from.fy, &result.camera.fy);
  fill_in(from.cx, &result.camera.cx);
  fill_in(from.cy, &result.camera.cy);
  fill_in(options.calibration.depth_scale, &result.depth_scale);
  if (!options.color_source.empty()) result.want_color = false;
  return result;
}

SourceOptions color_options(const SourceOptions& options) {
  SourceOptions result = options;
  result.camera = {};
  result.camera.width = options.calibration.color.camera.width;
  result.camera.height = options.calibration.color.camera.height;
  result.depth_scale = 0;
  return result;
}

Expected<std::unique_ptr<FrameSource>> calibrate(std::unique_ptr<FrameSource> source,
                                                 const CameraCalibration& calibration) {
  if (calibration.file.empty()) return source;
  const auto factors = read_factors(calibration.correction.factor_file);
  if (!factors) return factors.error();
  return CalibratedSource::create(std::move(source), calibration, *factors);
}

}  // namespace loopsift
