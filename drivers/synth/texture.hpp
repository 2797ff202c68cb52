// SPDX-License-Identifier: MIT
// Procedural surfaces: a periodic grey pattern blends two colours. Sampling never allocates and is
// thread-safe.
#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "core/geometry/image.hpp"

namespace loopsift {

enum class Pattern : std::uint8_t {
  kPlain,    ///< base colour alone
  kMottled,  ///< fractal noise: plaster, carpet, foliage
  kWood,     ///< grain along u
  kTiles,    ///< joints and a shade of its own for every tile
  kStripes,  ///< soft stripes along v: fabric
  kPicture,  ///< strongly coloured blobs
};

struct Material {
  Eigen::Vector3f base = {0.7F, 0.7F, 0.7F};    ///< RGB in [0, 1]
  Eigen::Vector3f accent = {0.5F, 0.5F, 0.5F};  ///< where the pattern is 1
  Pattern pattern = Pattern::kPlain;
  float tile_m = 1.0F;  ///< the pattern repeats after this length
};

/// The material's colour at surface coordinates u, v (metres), in [0, 1].
[[nodiscard]] Eigen::Vector3f sample_material(const Material& material, float u_m, float v_m);

}  // namespace loopsift
