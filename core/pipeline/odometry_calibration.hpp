// SPDX-License-Identifier: MIT
// How far the odometry's own uncertainty is to be believed, found from the data.
//
// Neighbouring fragments overlap, so they can be registered to each other; how far the odometry's motion
// between them is from the registered one, in units of what it claims, tells the common factor of its
// covariances: the median of the normalised squared differences over that of χ² with six degrees of freedom.
// So a foreign trajectory needs no uncertainty, and a mis-scaled one does no harm. Thread: back. Allocates.
#pragma once
#include <vector>

#include "core/fragment/fragment.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "core/proposal/icp.hpp"
#include "core/proposal/registration_cloud.hpp"

namespace loopsift {

class OdometryCalibration {
 public:
  OdometryCalibration(const RegistrationCloudOptions& cloud, const IcpOptions& icp);

  /// The next fragment, and the graph that holds it and the one before. A pair that cannot be registered says
  /// nothing.
  void add(const Fragment& fragment, const PoseGraph& odometry);
  /// Factor for the odometry's covariances; 1 until there are kMinPairs pairs.
  [[nodiscard]] double covariance_factor() const;
  static constexpr std::size_t kMinPairs = 3;

 private:
  IcpOptions icp_;
  VoxelThinner thinner_;
  RegistrationCloud previous_, current_;
  NearestField field_;
  Se3 T_odom_previous_;
  std::vector<double> normalised_;  // squared differences
};

}  // namespace loopsift
