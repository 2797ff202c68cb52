// SPDX-License-Identifier: MIT
#include "tools/evaluation/trajectory_error.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <string>

namespace loopsift {
namespace {

constexpr std::size_t kMinPairs = 3;  // a rigid alignment needs three points
constexpr double kRpeInterval_s = 1.0;
constexpr double kDegreesPerRadian = 57.29577951308232;

Error usage(std::string message) { return {ErrorCode::kUsage, std::move(message)}; }

double seconds(const Trajectory& trajectory, std::size_t k, double rate_hz) {
  const double t = trajectory.poses[k].time_s;
  return trajectory.indexed ? t / rate_hz : t;
}

std::string time_range(const Trajectory& trajectory, double rate_hz) {
  if (trajectory.poses.empty()) return "nothing";
  return std::to_string(seconds(trajectory, 0, rate_hz)) + " to " +
         std::to_string(seconds(trajectory, trajectory.poses.size() - 1, rate_hz)) + " s";
}

Expected<std::vector<PosePair>> pair_by_index(const Trajectory& gt, const Trajectory& est, double rate_hz) {
  if (gt.poses.size() != est.poses.size())
    return usage("the trajectories have " + std::to_string(gt.poses.size()) + " and " +
                 std::to_string(est.poses.size()) + " poses; pairing by index needs equally many");
  std::vector<PosePair> pairs;
  for (std::size_t k = 0; k < gt.poses.size(); ++k)
    pairs.push_back({seconds(gt, k, rate_hz), gt.poses[k].T_world_camera, est.poses[k].T_world_camera});
  return pairs;
}

Expected<std::vector<PosePair>> pair_by_time(const Trajectory& gt, const Trajectory& est,
                                             const AssociationOptions& options) {
  if (gt.indexed != est.indexed)
    return usage(
        "one trajectory is by frame number and the other by seconds; pair them by index, or write both in "
        "one "
        "format");
  std::vector<PosePair> pairs;
  std::size_t g = 0;
  for (std::size_t e = 0; e < est.poses.size() && !gt.poses.empty(); ++e) {
    const double t = seconds(est, e, options.rate_hz);
    const auto difference = [&](std::size_t k) { return std::abs(seconds(gt, k, options.rate_hz) - t); };
    while (g + 1 < gt.poses.size() && difference(g + 1) <= difference(g)) ++g;
    if (difference(g) > options.max_difference_s) continue;
    pairs.push_back({t, gt.poses[g].T_world_camera, est.poses[e].T_world_camera});
  }
  if (pairs.empty())
    return usage("the trajectories have no time in common: ground truth holds " +
                 time_range(gt, options.rate_hz) + ", the estimate " + time_range(est, options.rate_hz));
  return pairs;
}

}  // namespace

Expected<std::vector<PosePair>> associate(const Trajectory& gt, const Trajectory& est,
                                          const AssociationOptions& options) {
  auto pairs = options.by_index ? pair_by_index(gt, est, options.rate_hz) : pair_by_time(gt, est, options);
  if (pairs.ok() && pairs->size() < kMinPairs)
    return usage("the trajectories have only " + std::to_string(pairs->size()) +
                 " poses in common; an alignment needs 3 or more");
  return pairs;
}

Se3 align(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d mean_gt = Eigen::Vector3d::Zero(), mean_est = Eigen::Vector3d::Zero();
  for (const PosePair& p : pairs) {
    mean_gt += p.T_gt_camera.translation();
    mean_est += p.T_est_camera.translation();
  }
  mean_gt /= static_cast<double>(pairs.size());
  mean_est /= static_cast<double>(pairs.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PosePair& p : pairs)
    covariance +=
        (p.T_gt_camera.translation() - mean_gt) * (p.T_est_camera.translation() - mean_est).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) sign.z() = -1;
  const Eigen::Matrix3d R_gt_est = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  return {R_gt_est, mean_gt - R_gt_est * mean_est};
}

TrajectoryError trajectory_error(const std::vector<PosePair>& pairs) {
  const Se3 T_gt_est = align(pairs);
  const auto n = static_cast<double>(pairs.size());
  TrajectoryError error;
  error.pairs = static_cast<int>(pairs.size());
  double squares = 0;
  for (const PosePair& p : pairs) {
    const double d = (p.T_gt_camera.translation() - T_gt_est * p.T_est_camera.translation()).norm();
    squares += d * d;
    error.ate_mean_m += d / n;
    error.ate_max_m = std::max(error.ate_max_m, d);
  }
  error.ate_rmse_m = std::sqrt(squares / n);

  double trans_squares = 0, rot_squares = 0, count = 0;
  std::size_t j = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i, ++count) {
    while (j < pairs.size() && pairs[j].time_s - pairs[i].time_s < kRpeInterval_s) ++j;
    if (j == pairs.size()) break;
    const Se3 T_gt_i_j = pairs[i].T_gt_camera.inverse() * pairs[j].T_gt_camera;
    const Se3 T_est_i_j = pairs[i].T_est_camera.inverse() * pairs[j].T_est_camera;
    const Se3 difference = T_gt_i_j.inverse() * T_est_i_j;
    trans_squares += difference.translation().squaredNorm();
    rot_squares += difference.angle() * difference.angle();
  }
  if (count > 0) {
    error.rpe_trans_rmse_m = std::sqrt(trans_squares / count);
    error.rpe_rot_rmse_deg = std::sqrt(rot_squares / count) * kDegreesPerRadian;
  }
  return error;
}

}  // namespace loopsift
