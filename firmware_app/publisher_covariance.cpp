// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace loopsift {
namespace {

Matrix6d carried(const Matrix6d& adjoint, const Matrix6d& covariance) {
  return adjoint * covariance * adjoint.transpose();
}

}  // namespace

void CovarianceTracker::add(std::int64_t timestamp_ns, const Se3& T_odom_camera,
                            const Matrix6d& information) {
  Matrix6d sum = count_ == 0 ? Matrix6d(Matrix6d::Zero()) : newest_entry().sum;
  const Eigen::LLT<Matrix6d> cholesky(information);
  if (count_ > 0 && cholesky.info() == Eigen::Success) {
    const Matrix6d motion = cholesky.solve(Matrix6d::Identity());
    if (motion.allFinite()) sum += carried(T_odom_camera.adjoint(), motion);
  }
  Entry& entry = ring_[count_++ % kHistory];
  entry.timestamp_ns = timestamp_ns;
  entry.T_odom_camera = T_odom_camera;
  entry.sum = sum;
}

void CovarianceTracker::correct(std::int64_t timestamp_ns, const Matrix6d& covariance) {
  if (count_ == 0 || !covariance.allFinite()) return;
  const Entry& entry = entry_at(timestamp_ns);
  base_ = carried(entry.T_odom_camera.adjoint(), covariance);
  base_sum_ = entry.sum;
}

Matrix6d CovarianceTracker::newest() const {
  if (count_ == 0) return Matrix6d::Zero();
  const Entry& entry = newest_entry();
  return carried(entry.T_odom_camera.inverse().adjoint(), base_ + entry.sum - base_sum_);
}

const CovarianceTracker::Entry& CovarianceTracker::entry_at(std::int64_t timestamp_ns) const {
  const std::size_t remembered = std::min(count_, kHistory);
  for (std::size_t age = 1; age < remembered; ++age) {
    const Entry& entry = ring_[(count_ - age) % kHistory];
    if (entry.timestamp_ns <= timestamp_ns) return entry;
  }
  return ring_[(count_ - remembered) % kHistory];
}

}  // namespace loopsift
