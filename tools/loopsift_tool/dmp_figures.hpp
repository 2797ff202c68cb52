// SPDX-License-Identifier: MIT
// What the dense map posterior of a trajectory comes to. Zhang & Chen, "A metric for evaluating 3D
// reconstruction and mapping performance with no ground truthing" (2021).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift::tool {

class OfflineMap;

/// One view's part.
struct ViewDmp {
  int frame = 0;  ///< number in the recording
  int fragment = 0;
  double time_s = 0;
  double dmp = 0;  ///< m², mean squared residual
};

struct DmpFigures {
  double dmp = 0;                 ///< m², sum over views
  std::int64_t views = 0;         ///< frames scored
  std::int64_t valid_pixels = 0;  ///< Σ |Ω|: with measured and predicted depth
  std::vector<ViewDmp> per_view;  ///< in order of time
};

/// Pictures of the residual (residual_image.hpp).
struct HeatmapOptions {
  std::string folder;  ///< made when missing; frame-NNNNNN.png go there; empty: none
  int every = 10;      ///< frames from one picture to the next
};

/// The reduced form: the map's score views, its fragments at these poses. Pictures have the size of the
/// views. Error: a picture that cannot be written.
[[nodiscard]] Expected<DmpFigures> reduced_dmp(OfflineMap& map, const std::vector<Se3>& T_map_fragment,
                                               const HeatmapOptions& heatmaps);

}  // namespace loopsift::tool
