// SPDX-License-Identifier: MIT
// What a report says about a run beyond the run's own files: its errors against ground truth, which loops are
// true, precision and recall along its ranking, the score of each view before and after. Desk code:
// allocates.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.hpp"
#include "tools/evaluation/loop_error.hpp"
#include "tools/loopsift_tool/map_residual.hpp"

namespace loopsift::tool {

/// Empty names: not given.
struct RunEvaluationOptions {
  std::string folder;             ///< what --out of the run named
  std::string gt;                 ///< true trajectory
  std::string gt_loops, gt_info;  ///< labelled pairs of fragments, redwood .log and .info
  LoopEvaluationOptions labels;
  std::string source;  ///< URI of the recording, for the map's residual
};

struct RunEvaluation {
  nlohmann::ordered_json json;
  MapResidual residual;  ///< empty without source
};

/// truth: {odometry, corrected: {keys of eval-trajectory, time_s, error_m, truth, estimate (positions in the
/// map's frame)}}; loops: [{id, error_m, error_deg, correct}]; ranking: {about, average_precision, curve};
/// dmp_views: {frame, time_s, before, after}; notes. Parts whose input is missing are left out; for what the
/// user named and the run has not (yet) the files, there is a note. A loop without label is judged by the
/// true trajectory: true within 0.10 m and 5°. Errors: an input that the user named is wrong or does not fit
/// the run.
[[nodiscard]] Expected<RunEvaluation> evaluate_run(const RunEvaluationOptions& options);

}  // namespace loopsift::tool
