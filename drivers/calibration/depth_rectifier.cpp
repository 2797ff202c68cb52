// SPDX-License-Identifier: MIT
#include "drivers/calibration/depth_rectifier.hpp"

#include <cassert>
#include <cmath>

#include "drivers/calibration/lens.hpp"

namespace loopsift {
namespace {

constexpr std::uint32_t kInvalid = 65535;      // besides 0
constexpr std::uint32_t kUnityFactor = 32768;  // 16-bit fixed point

std::uint16_t valid_or_zero(std::uint32_t depth) {
  return depth < kInvalid ? static_cast<std::uint16_t>(depth) : std::uint16_t{0};
}

}  // namespace

DepthRectifier::DepthRectifier(const LensCalibration& lens, const DepthCorrection& correction, double unit_m,
                               const std::vector<std::uint16_t>& factors) {
  if (lens.distortion.is_identity() && !lens.mirrored && correction.is_identity()) return;
  map_pixels(lens);
  map_depths(correction, unit_m);
  if (factors.empty()) return;
  assert(factors.size() == source_.size());
  factors_.resize(source_.size());
  for (std::size_t i = 0; i < source_.size(); ++i)
    factors_[i] = source_[i] < 0 ? std::uint16_t{0} : factors[static_cast<std::size_t>(source_[i])];
}

void DepthRectifier::map_pixels(const LensCalibration& lens) {
  const int width = lens.camera.width, height = lens.camera.height;
  source_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector2d at = device_pixel(lens, u, v);
      const double column = std::floor(at.x() + 0.5), row = std::floor(at.y() + 0.5);
      const bool inside = column >= 0 && row >= 0 && column < width && row < height;
      source_.push_back(inside ? static_cast<std::int32_t>(row) * width + static_cast<std::int32_t>(column)
                               : -1);
    }
  }
}

void DepthRectifier::map_depths(const DepthCorrection& correction, double unit_m) {
  corrected_.assign(kInvalid + 1, 0);
  for (std::uint32_t raw = 1; raw < kInvalid; ++raw) {
    const double depth = std::floor(correction.polynomial(raw * unit_m) / unit_m + 0.5);
    if (depth > 0 && depth < kInvalid) corrected_[raw] = static_cast<std::uint16_t>(depth);
  }
}

void DepthRectifier::rectify(const ImageView<const std::uint16_t>& device,
                             const ImageView<std::uint16_t>& out) const {
  assert(device.size() == source_.size() && out.size() == source_.size());
  assert(device.stride == device.width && out.stride == out.width);
  const std::size_t count = source_.size();
  for (std::size_t i = 0; i < count; ++i)
    out.data[i] = source_[i] < 0 ? std::uint16_t{0} : corrected_[device.data[source_[i]]];
  for (std::size_t i = 0; i < factors_.size(); ++i)
    out.data[i] = valid_or_zero((out.data[i] * std::uint32_t{factors_[i]} + kUnityFactor / 2) / kUnityFactor);
}

}  // namespace loopsift
