// SPDX-License-Identifier: MIT
// How far an estimated trajectory is from the true one. In: two trajectories, each in its own world. Out: the
// absolute trajectory error after a rigid alignment, and the relative pose error over a second (Sturm et al.,
// A Benchmark for the Evaluation of RGB-D SLAM Systems, 2012). Desk code: allocates.
#pragma once
#include <optional>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/se3.hpp"
#include "core/geometry/trajectory.hpp"

namespace loopsift {

/// The true and the estimated pose of one camera frame.
struct PosePair {
  double time_s = 0;
  Se3 T_gt_camera;
  Se3 T_est_camera;
};

struct AssociationOptions {
  double max_difference_s = 0.02;  ///< between time stamps that are taken for one frame
  double rate_hz = 30.0;           ///< turns the frame numbers of redwood .log files into seconds
  bool by_index = false;  ///< the k-th pose of one file is the k-th of the other, whatever their times
};

/// Pairs each estimated pose with the true pose nearest in time, in order of time. Errors: nothing within
/// max_difference_s, fewer than 3 pairs, one trajectory with seconds and one with frame numbers (unless
/// by_index), other lengths (by_index).
[[nodiscard]] Expected<std::vector<PosePair>> associate(const Trajectory& gt, const Trajectory& est,
                                                        const AssociationOptions& options);

/// T_gt_est that minimises Σ ‖p_gt − T_gt_est p_est‖² over the camera positions, without scale (Umeyama 1991,
/// eq. 39–42 with c = 1). Where the positions lie on a line or in one point, the rotation is one of the best.
[[nodiscard]] Se3 align(const std::vector<PosePair>& pairs);

struct TrajectoryError {
  int pairs = 0;
  double ate_rmse_m = 0, ate_mean_m = 0, ate_max_m = 0;
  std::optional<double> rpe_trans_rmse_m;  ///< over one second; none when no two pairs are a second apart
  std::optional<double> rpe_rot_rmse_deg;  ///< the same
};

/// RPE: for each pair i, against the first pair at least a second later: (Gtᵢ⁻¹ Gtⱼ)⁻¹ (Estᵢ⁻¹ Estⱼ).
[[nodiscard]] TrajectoryError trajectory_error(const std::vector<PosePair>& pairs);

}  // namespace loopsift
