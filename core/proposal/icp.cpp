// SPDX-License-Identifier: MIT
#include "core/proposal/icp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

using Vector6f = Eigen::Matrix<float, 6, 1>;
using Matrix6f = Eigen::Matrix<float, 6, 6>;

/// The partner of a source point that is already in the target's frame: index into the target, or −1.
int partner_of(const IcpTarget& target, const Eigen::Vector3f& p, const Eigen::Vector3f& n,
               float squared_distance, float min_normal_cosine) {
  const std::uint16_t q = target.field->nearest(p);
  if (q == NearestField::kNone) return -1;
  if (!((target.cloud->points[q] - p).squaredNorm() < squared_distance)) return -1;
  return target.cloud->normals[q].dot(n) > min_normal_cosine ? static_cast<int>(q) : -1;
}

float variance_of(const IcpOptions& options, const Eigen::Vector3f& p) {
  const float sigma = options.sigma_floor_m + options.sigma_slope_per_m * p.squaredNorm();
  return sigma * sigma;
}

/// False where the covariance is no covariance or exceeds the limits.
bool is_determined(const IcpOptions& options, const Matrix6d& information) {
  const Eigen::LDLT<Matrix6d> ldlt(information);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return false;
  const Vector6d variance = ldlt.solve(Matrix6d::Identity()).diagonal();
  const double limit_m = static_cast<double>(options.max_sigma_m);
  const double limit_rad = static_cast<double>(options.max_sigma_rad);
  return variance.minCoeff() > 0 && variance.head<3>().maxCoeff() < limit_m * limit_m &&
         variance.tail<3>().maxCoeff() < limit_rad * limit_rad;
}

/// One Gauss–Newton step, slightly damped: a direction that the partners do not see stays as it was.
bool step(const PointToPlaneSystem& system, Vector6d* xi) {
  Matrix6d damped = system.H;
  damped.diagonal().array() += 1e-4 * system.H.trace();
  *xi = -damped.ldlt().solve(system.g);
  return xi->allFinite();
}

}  // namespace

PointToPlaneSystem point_to_plane_system(const IcpOptions& options, const IcpTarget& target,
                                         const RegistrationCloud& source, const Se3& T, float max_distance_m,
                                         int stride, Loss loss) {
  PointToPlaneSystem system;
  const Se3f Tf(T);
  const float s2 = max_distance_m * max_distance_m / 9.0F;
  Matrix6f H = Matrix6f::Zero();
  Vector6f g = Vector6f::Zero();
  for (std::size_t k = 0; k < source.size(); k += static_cast<std::size_t>(stride)) {
    const Eigen::Vector3f p = Tf * source.points[k];
    const int partner = partner_of(target, p, Tf.R * source.normals[k], max_distance_m * max_distance_m,
                                   options.min_normal_cosine);
    if (partner < 0) continue;
    const Eigen::Vector3f& q = target.cloud->points[static_cast<std::size_t>(partner)];
    const Eigen::Vector3f& n = target.cloud->normals[static_cast<std::size_t>(partner)];
    const float r = n.dot(p - q);
    const float w = 1.0F / (variance_of(options, source.points[k]) + variance_of(options, q));
    const float root = loss == Loss::kGemanMcClure ? s2 / (s2 + r * r) : 1.0F;
    // T exp(ξ) p ≈ T p + R (t + ω × p), so dr = (Rᵀn) · t + (p × Rᵀn) · ω.
    const Eigen::Vector3f m = Tf.R.transpose() * n;
    const Eigen::Vector3f c = source.points[k].cross(m);
    const Vector6f J{{m.x(), m.y(), m.z(), c.x(), c.y(), c.z()}};
    H.noalias() += (w * root * root * J) * J.transpose();
    g += (w * root * root * r) * J;
    system.cost += static_cast<double>(0.5F * w * root * r * r);
    system.squared_residuals += static_cast<double>(r * r);
    ++system.partners;
  }
  system.H = H.cast<double>();
  system.g = g.cast<double>();
  return system;
}

IcpResult refine(const IcpOptions& options, const IcpTarget& target, const RegistrationCloud& source,
                 const Se3& T_start) {
  IcpResult result;
  result.T_target_source = T_start;
  for (const IcpStage& stage : options.stages) {
    for (int iteration = 0; iteration < stage.max_iterations; ++iteration) {
      const PointToPlaneSystem system =
          point_to_plane_system(options, target, source, result.T_target_source, stage.max_distance_m,
                                stage.stride, Loss::kGemanMcClure);
      Vector6d xi;
      if (system.partners * stage.stride < options.min_partners || !step(system, &xi)) return result;
      result.T_target_source = (result.T_target_source * Se3::exp(xi)).normalized();
      if (xi.head<3>().norm() < static_cast<double>(options.converged_m) &&
          xi.tail<3>().norm() < static_cast<double>(options.converged_rad))
        break;
    }
  }
  const PointToPlaneSystem system =
      point_to_plane_system(options, target, source, result.T_target_source,
                            options.stages.back().max_distance_m, 1, Loss::kSquared);
  result.partners = system.partners;
  if (system.partners < options.min_partners) return result;
  result.residual_m = static_cast<float>(std::sqrt(system.squared_residuals / system.partners));
  const double variance_factor = std::max(1.0, 2.0 * system.cost / system.partners);
  result.information = system.H / (variance_factor * static_cast<double>(options.correlated_pairs));
  result.fits = result.T_target_source.is_valid();
  result.ok = result.fits && is_determined(options, result.information);
  return result;
}

}  // namespace loopsift
