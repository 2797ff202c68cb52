// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/residual_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "drivers/replay/image_file.hpp"

namespace loopsift::tool {
namespace {

constexpr double kFullColor_m = 0.10;
constexpr Rgb8 kNotPredicted = {70, 70, 70}, kInFront = {178, 24, 43}, kBehind = {33, 102, 172};

unsigned char blend(unsigned char full, double share) {
  return static_cast<unsigned char>(std::lround(255.0 + share * (static_cast<double>(full) - 255.0)));
}

}  // namespace

Rgb8 residual_color(double predicted_m, double measured_m) {
  if (!(measured_m > 0)) return {0, 0, 0};
  if (!(predicted_m > 0)) return kNotPredicted;
  const double residual = predicted_m - measured_m;
  const double share = std::min(std::abs(residual) / kFullColor_m, 1.0);
  const Rgb8 full = residual < 0 ? kInFront : kBehind;
  return {blend(full.r, share), blend(full.g, share), blend(full.b, share)};
}

Status write_residual_image(const std::string& folder, int frame, const ImageView<const float>& measured_m,
                            const ImageView<const float>& inverse_depth) {
  std::vector<Rgb8> pixels;
  pixels.reserve(measured_m.size());
  for (int y = 0; y < measured_m.height; ++y)
    for (int x = 0; x < measured_m.width; ++x) {
      const auto inverse = static_cast<double>(inverse_depth(x, y));
      pixels.push_back(
          residual_color(inverse > 0 ? 1.0 / inverse : 0.0, static_cast<double>(measured_m(x, y))));
    }
  char name[32];
  std::snprintf(name, sizeof name, "/frame-%06d.png", frame);
  return write_png_rgb(folder + name,
                       ImageView<const Rgb8>(pixels.data(), measured_m.width, measured_m.height));
}

}  // namespace loopsift::tool
