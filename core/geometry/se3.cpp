// SPDX-License-Identifier: MIT
#include "core/geometry/se3.hpp"

#include <Eigen/SVD>
#include <cmath>

namespace loopsift {
namespace {

constexpr double kSmallAngle = 1e-5;  // below it the closed forms lose digits and series take over

// Coefficients of the series in θ that the closed forms share: A = sinθ/θ, B = (1−cosθ)/θ², C = (θ−sinθ)/θ³.
struct Coefficients {
  double a, b, c;
};

Coefficients coefficients(double theta) {
  const double t2 = theta * theta;
  if (theta < kSmallAngle) return {1.0 - t2 / 6.0, 0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0};
  const double half_sine = std::sin(0.5 * theta);  // 1−cosθ = 2 sin²(θ/2), without its cancellation
  return {std::sin(theta) / theta, 2.0 * half_sine * half_sine / t2,
          (theta - std::sin(theta)) / (t2 * theta)};
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d S = Eigen::Matrix3d::Identity();
  S(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * S * svd.matrixV().transpose();
}

// Q of Barfoot (7.86): the coupling block of the SE(3) left Jacobian.
Eigen::Matrix3d coupling(const Eigen::Vector3d& rho, const Eigen::Vector3d& phi) {
  const double t = phi.norm(), t2 = t * t;
  const Eigen::Matrix3d P = skew(phi), V = skew(rho);
  double m2, m3, m4;
  if (t < 0.05) {  // the fifth-order quotients cancel badly: series from an angle larger than kSmallAngle
    m2 = 1.0 / 6.0 - t2 / 120.0 + t2 * t2 / 5040.0;
    m3 = 1.0 / 24.0 - t2 / 720.0 + t2 * t2 / 40320.0;
    m4 = 1.0 / 120.0 - t2 / 2520.0 + t2 * t2 / 120960.0;
  } else {
    const double s = std::sin(t), c = std::cos(t);
    m2 = (t - s) / (t2 * t);
    m3 = (t2 + 2.0 * c - 2.0) / (2.0 * t2 * t2);
    m4 = (2.0 * t - 3.0 * s + t * c) / (2.0 * t2 * t2 * t);
  }
  return 0.5 * V + m2 * (P * V + V * P + P * V * P) + m3 * (P * P * V + V * P * P - 3.0 * P * V * P) +
         m4 * (P * V * P * P + P * P * V * P);
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& w) {
  const Coefficients k = coefficients(w.norm());
  const Eigen::Matrix3d W = skew(w);
  return Eigen::Matrix3d::Identity() + k.a * W + k.b * W * W;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);  // through the quaternion: stable near 0 and near π
  const double n = q.vec().norm();
  const double w = q.w() < 0 ? -q.w() : q.w();
  const Eigen::Vector3d v = q.w() < 0 ? Eigen::Vector3d(-q.vec()) : Eigen::Vector3d(q.vec());
  if (n < 1e-10) return 2.0 * v;
  return (2.0 * std::atan2(n, w) / n) * v;
}

Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& w) {
  const Coefficients k = coefficients(w.norm());
  const Eigen::Matrix3d W = skew(w);
  return Eigen::Matrix3d::Identity() + k.b * W + k.c * W * W;
}

Eigen::Matrix3d so3_left_jacobian_inverse(const Eigen::Vector3d& w) {
  const double t = w.norm(), t2 = t * t;
  const Eigen::Matrix3d W = skew(w);
  // (1+cosθ)/sinθ = cot(θ/2), which holds at π too.
  const double k = t < 1e-4 ? 1.0 / 12.0 + t2 / 720.0 : 1.0 / t2 - 1.0 / (2.0 * t * std::tan(0.5 * t));
  return Eigen::Matrix3d::Identity() - 0.5 * W + k * W * W;
}

Se3 Se3::from_matrix(const Eigen::Matrix4d& T) {
  return {nearest_rotation(T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>()};
}

Se3 Se3::exp(const Vector6d& xi) {
  const Eigen::Vector3d w = xi.tail<3>();
  return {so3_exp(w), so3_left_jacobian(w) * xi.head<3>()};
}

Eigen::Matrix4d Se3::matrix() const {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = R_;
  T.topRightCorner<3, 1>() = t_;
  return T;
}

Vector6d Se3::log() const {
  Vector6d xi;
  xi.tail<3>() = so3_log(R_);
  xi.head<3>() = so3_left_jacobian_inverse(xi.tail<3>()) * t_;
  return xi;
}

Matrix6d Se3::adjoint() const {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = R_;
  A.bottomRightCorner<3, 3>() = R_;
  A.topRightCorner<3, 3>() = skew(t_) * R_;
  return A;
}

Se3 Se3::normalized() const { return {quaternion().normalized().toRotationMatrix(), t_}; }

bool Se3::is_valid() const {
  return t_.allFinite() && R_.allFinite() &&
         (R_ * R_.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 &&
         R_.determinant() > 0;
}

Matrix6d se3_left_jacobian(const Vector6d& xi) {
  Matrix6d J = Matrix6d::Zero();
  const Eigen::Matrix3d J3 = so3_left_jacobian(xi.tail<3>());
  J.topLeftCorner<3, 3>() = J3;
  J.bottomRightCorner<3, 3>() = J3;
  J.topRightCorner<3, 3>() = coupling(xi.head<3>(), xi.tail<3>());
  return J;
}

Matrix6d se3_left_jacobian_inverse(const Vector6d& xi) {
  Matrix6d J = Matrix6d::Zero();
  const Eigen::Matrix3d J3 = so3_left_jacobian_inverse(xi.tail<3>());
  J.topLeftCorner<3, 3>() = J3;
  J.bottomRightCorner<3, 3>() = J3;
  J.topRightCorner<3, 3>() = -J3 * coupling(xi.head<3>(), xi.tail<3>()) * J3;
  return J;
}

Se3 interpolate(const Se3& a, const Se3& b, double s) { return a * Se3::exp(s * (a.inverse() * b).log()); }

}  // namespace loopsift
