// SPDX-License-Identifier: MIT
#include "core/pipeline/odometry_calibration.hpp"

#include <algorithm>
#include <utility>

namespace loopsift {
namespace {

constexpr double kMedianChi2 = 5.348;    // of six degrees of freedom
constexpr double kLeastFactor = 1e-6;    // an odometry without any error must not divide by zero
constexpr int kMaxFieldCells = 1 << 20;  // 4 MiB; larger fragments get larger cells

// Covariance of the odometry's motion from one fragment's reference node to the next one's: the edges
// between, carried into the last node by the adjoint.
Matrix6d motion_covariance(const PoseGraph& odometry, int from, int to) {
  Matrix6d covariance = Matrix6d::Zero();
  for (const Edge& edge : odometry.odometry) {
    if (edge.a < from || edge.b > to) continue;
    const Se3 T_to_b = odometry.T_map_node[static_cast<std::size_t>(to)].inverse() *
                       odometry.T_map_node[static_cast<std::size_t>(edge.b)];
    const Matrix6d A = T_to_b.adjoint();
    covariance += A * edge.information.inverse() * A.transpose();
  }
  return covariance;
}

}  // namespace

OdometryCalibration::OdometryCalibration(const RegistrationCloudOptions& cloud, const IcpOptions& icp)
    : icp_(icp), thinner_(cloud) {}

void OdometryCalibration::add(const Fragment& fragment, const PoseGraph& odometry) {
  std::swap(previous_, current_);
  const Se3 T_previous_fragment = T_odom_previous_.inverse() * fragment.T_odom_fragment;
  T_odom_previous_ = fragment.T_odom_fragment;
  thinner_.thin(fragment.surfels, &current_);
  const bool target = fragment.id.value > 0 && fragment.joined_to_previous && previous_.size() > 0;
  if (!target) return;
  field_.build(previous_.points, icp_.stages.front().max_distance_m, icp_.stages.back().max_distance_m,
               kMaxFieldCells);
  const IcpResult registered = refine(icp_, {&previous_, &field_}, current_, T_previous_fragment);
  if (!registered.ok) return;
  const auto f = fragment.id.index();
  const Matrix6d covariance = motion_covariance(odometry, odometry.first_node[f - 1], odometry.first_node[f]);
  const Vector6d difference = (registered.T_target_source.inverse() * T_previous_fragment).log();
  normalised_.push_back(difference.dot(covariance.ldlt().solve(difference)));
}

double OdometryCalibration::covariance_factor() const {
  if (normalised_.size() < kMinPairs) return 1.0;
  std::vector<double> sorted = normalised_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return std::max(*middle / kMedianChi2, kLeastFactor);
}

}  // namespace loopsift
