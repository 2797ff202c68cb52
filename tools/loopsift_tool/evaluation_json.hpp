// SPDX-License-Identifier: MIT
// Results of tools/evaluation as JSON.
#pragma once
#include <nlohmann/json.hpp>

#include "tools/evaluation/loop_ranking.hpp"
#include "tools/evaluation/trajectory_error.hpp"

namespace loopsift::tool {

/// One object per loop: rank, id, fragment_i, fragment_j, correct, accepted, recall, precision.
[[nodiscard]] nlohmann::ordered_json ranking_json(const Ranking& ranking);

/// The keys of eval-trajectory; what could not be measured is null.
[[nodiscard]] nlohmann::ordered_json trajectory_error_json(const TrajectoryError& error);

}  // namespace loopsift::tool
