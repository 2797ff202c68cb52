// SPDX-License-Identifier: MIT
// How well a run's map predicts the depth that was measured, surfel by surfel and view by view, where the
// odometry had the fragments and where the run put them. In: map.ply, both trajectories, the recording. Out:
// for each surfel the mean of |D̂ − D| over the views that see it; for each view its part of the dense map
// posterior. Desk code: allocates; a thread that decodes, OpenMP.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"

namespace loopsift::tool {

struct MapResidual {
  std::vector<float> before_m, after_m;  ///< by surfel of map.ply; NaN where no view sees it
  struct View {
    int frame = 0;  ///< number in the recording
    double time_s = 0;
    double before_m2 = 0, after_m2 = 0;  ///< mean squared residual
  };
  std::vector<View> views;  ///< in order of time
};

struct MapResidualInput {
  std::string map;                            ///< map.ply of the run
  std::string odometry;                       ///< trajectory_odometry.txt: which frames, and where they were
  const Trajectory* T_odom_camera = nullptr;  ///< the same, read
  const Trajectory* T_map_camera = nullptr;   ///< trajectory.txt
  std::string source;                         ///< URI of the recording
};

/// Looks at every frame of a short recording, else at some 400 evenly spread ones, at no more than 160 pixels
/// across, depth within 0.3 and 15 m. A surfel is seen where it is what the map shows at its pixel. Errors:
/// the map does not tell its fragments, a source that cannot be opened or is lost or is another recording.
[[nodiscard]] Expected<MapResidual> measure_map_residual(const MapResidualInput& input);

}  // namespace loopsift::tool
