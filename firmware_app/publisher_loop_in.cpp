// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_loop_in.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <loopsift/loop_in_t.hpp>

#include "core/geometry/body_axes.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kLatest_us = std::numeric_limits<std::int64_t>::max() / 1000;
constexpr double kSameLength = 0.01;  // a unit quaternion's length is within this of 1

/// 1 cm and half a degree.
Matrix6d usual_covariance() {
  Vector6d variance;
  variance.head<3>().setConstant(0.01 * 0.01);
  variance.tail<3>().setConstant(0.00873 * 0.00873);
  return variance.asDiagonal();
}

}  // namespace

bool parse_loop_in(const void* bytes, std::size_t size, OutsideLoop* loop) {
  loop_in_t message{};
  const int expected = message.getEncodedSize();
  if (size != static_cast<std::size_t>(expected) || message.decode(bytes, 0, expected) != expected)
    return false;
  if (message.utime_i < 0 || message.utime_i > kLatest_us || message.utime_j < 0 ||
      message.utime_j > kLatest_us)
    return false;
  const double* q = message.T_i_j.quat;
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d translation(message.T_i_j.trans[0], message.T_i_j.trans[1], message.T_i_j.trans[2]);
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1.0) < kSameLength)) return false;

  Matrix6d covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.covariance);
  if (!covariance.allFinite()) return false;
  if (covariance.isZero(0.0)) covariance = usual_covariance();
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  if (Eigen::LLT<Matrix6d>(covariance).info() != Eigen::Success) return false;

  Matrix6d turned = Matrix6d::Zero();  // (t, ω) of the body to those of the camera
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = camera_to_body_axes().transpose();
  loop->timestamp_i_ns = message.utime_i * 1000;
  loop->timestamp_j_ns = message.utime_j * 1000;
  loop->T_i_j = camera_pose(Se3(rotation, translation), Se3());
  loop->covariance = turned * covariance * turned.transpose();
  return true;
}

}  // namespace loopsift
