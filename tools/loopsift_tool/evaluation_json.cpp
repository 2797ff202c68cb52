// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/evaluation_json.hpp"

namespace loopsift::tool {
namespace {

nlohmann::ordered_json value_or_null(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

nlohmann::ordered_json ranking_json(const Ranking& ranking) {
  auto curve = nlohmann::ordered_json::array();
  for (const RankingPoint& p : ranking.points)
    curve.push_back({{"rank", p.loop.rank},
                     {"id", p.loop.id},
                     {"fragment_i", p.loop.fragment_i},
                     {"fragment_j", p.loop.fragment_j},
                     {"correct", p.correct},
                     {"accepted", p.loop.accepted},
                     {"recall", p.recall},
                     {"precision", p.precision}});
  return curve;
}

nlohmann::ordered_json trajectory_error_json(const TrajectoryError& error) {
  return {{"ate_rmse_m", error.ate_rmse_m},
          {"ate_mean_m", error.ate_mean_m},
          {"ate_max_m", error.ate_max_m},
          {"rpe_trans_rmse_m", value_or_null(error.rpe_trans_rmse_m)},
          {"rpe_rot_rmse_deg", value_or_null(error.rpe_rot_rmse_deg)},
          {"pairs", error.pairs}};
}

}  // namespace loopsift::tool
