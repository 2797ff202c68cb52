// SPDX-License-Identifier: MIT
// The same loops through every filter. In: a map's odometry graph and loops. Out: what each filter kept, the
// poses it ends with, and how good both are. Desk code: allocates; contestants may run side by side.
#pragma once
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/evaluation/trajectory_error.hpp"
#include "tools/loopsift_tool/comparison/truth.hpp"
#include "tools/loopsift_tool/offline_map.hpp"

namespace loopsift::tool {

/// What the filters are given. The loops' ids are all different.
struct ContestInput {
  const OfflineMap* map = nullptr;
  PoseGraph odometry;  ///< of the map, calibrated, its information multiplied by odometry_factor
  double odometry_factor = 1.0;
  std::vector<Loop> loops;
  std::set<int> true_ids;  ///< of the loops that are true
};

/// What a filter left.
struct Outcome {
  std::set<int> accepted;       ///< ids
  std::vector<Se3> T_map_node;  ///< of all nodes of the graph
  double wall_s = 0;
  std::string failure;  ///< not empty: why there is no result; accepted is then empty and the odometry stays
};

struct Contestant {
  std::string name;
  std::function<Outcome(const ContestInput&)> run;
};

/// The published filters; loopsift with its posterior ("loopsift") and with the plain score
/// ("loopsift_plain"); and, no filter, least squares on exactly the true loops ("all true loops"). loopsift
/// is given the odometry as it is, times odometry_factor, and calibrates it by itself.
[[nodiscard]] const std::vector<Contestant>& contestants();

/// Fractions are absent where there is nothing to take them of, the error where there are fewer than three
/// true poses.
struct Figures {
  std::size_t accepted = 0;
  std::optional<double> precision, recall;
  std::optional<double> ate_rmse_m;
};

/// Corrected and true poses of the frames that have both.
[[nodiscard]] std::vector<PosePair> pose_pairs(const ContestInput& input, const Truth& truth,
                                               const Outcome& outcome);
[[nodiscard]] Figures judge(const ContestInput& input, const Truth& truth, const Outcome& outcome);

}  // namespace loopsift::tool
