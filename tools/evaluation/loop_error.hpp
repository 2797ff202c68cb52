// SPDX-License-Identifier: MIT
// Which of a list of loops are true. In: labelled pairs of fragments with the information matrix of their
// overlap, and loops. Out: recall and precision as in Choi, Zhou, Koltun, Robust Reconstruction of Indoor
// Scenes (2015), sec. 5 of the supplementary material. Desk code: allocates.
#pragma once
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"

namespace loopsift {

struct LoopEvaluationOptions {
  double max_error_m2 =
      0.04;  ///< a loop is true when ξᵀ Λ ξ / Λ₁₁ is at most this: 0.2 m RMS over the overlap
  int fragments = 0;  ///< look only at pairs of the first so many fragments; 0: at all of them
};

struct LoopError {
  int true_loops = 0;    ///< labelled pairs with j − i > 1
  int loops = 0;         ///< given loops with j − i > 1
  int correct = 0;       ///< loops among them that are true
  double recall = 0;     ///< labelled pairs that a correct loop joins / true_loops
  double precision = 0;  ///< correct / loops; 0 without loops
};

/// ξᵀ Λ ξ / Λ₁₁ of T against T_gt, m²; ξ = (t, 2 q_xyz) of T_gt⁻¹ T, Λ in (t, ω) order.
[[nodiscard]] double loop_error_m2(const Se3& T_gt, const Matrix6d& information, const Se3& T);

/// Neighbouring fragments (j − i = 1) are odometry, not loops, and are passed over. Errors: gt and gt_info
/// list other pairs; loops of another fragment count than the labels (unless options.fragments); a loop to a
/// fragment that is not there; no labelled pair.
[[nodiscard]] Expected<LoopError> evaluate_loops(const std::vector<LogRecord>& gt,
                                                 const std::vector<InfoRecord>& gt_info,
                                                 const std::vector<LogRecord>& loops,
                                                 const LoopEvaluationOptions& options);

/// Which loops of a list are true, one by one.
struct LoopVerdicts {
  int true_loops = 0;         ///< labelled pairs with j − i > 1
  std::vector<bool> counts;   ///< a loop (j − i > 1) among the fragments looked at
  std::vector<bool> correct;  ///< and a true one
};

/// The judgement behind evaluate_loops, with its errors.
[[nodiscard]] Expected<LoopVerdicts> correct_loops(const std::vector<LogRecord>& gt,
                                                   const std::vector<InfoRecord>& gt_info,
                                                   const std::vector<LogRecord>& loops,
                                                   const LoopEvaluationOptions& options);

}  // namespace loopsift
