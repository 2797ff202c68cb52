// SPDX-License-Identifier: MIT
// Rigid motions. T_a_b maps points from frame b to frame a: p_a = T_a_b * p_b. Tangent vectors are (t, ω):
// translation first, then rotation, metres and radians. Fixed size, never allocates. Formulas: Barfoot, State
// Estimation for Robotics (2017), ch. 7; Solà et al., A micro Lie theory (2018).
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace loopsift {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// [v]× such that [v]× w = v × w.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// Rotation of angle |w| about w (Rodrigues), and its inverse (angle in [0, π]).
[[nodiscard]] Eigen::Matrix3d so3_exp(const Eigen::Vector3d& w);
[[nodiscard]] Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);
/// Left Jacobian of SO(3) (Barfoot 7.77), and its inverse.
[[nodiscard]] Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& w);
[[nodiscard]] Eigen::Matrix3d so3_left_jacobian_inverse(const Eigen::Vector3d& w);

/// An element of SE(3), kept as rotation matrix and translation.
class Se3 {
 public:
  Se3() = default;  ///< identity
  Se3(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) : R_(R), t_(t) {}
  Se3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : R_(q.normalized().toRotationMatrix()), t_(t) {}
  /// From a homogeneous matrix whose rotation is brought to the nearest orthonormal one.
  [[nodiscard]] static Se3 from_matrix(const Eigen::Matrix4d& T);
  /// Exponential map of (t, ω).
  [[nodiscard]] static Se3 exp(const Vector6d& xi);

  [[nodiscard]] const Eigen::Matrix3d& rotation() const { return R_; }
  [[nodiscard]] const Eigen::Vector3d& translation() const { return t_; }
  [[nodiscard]] Eigen::Quaterniond quaternion() const { return Eigen::Quaterniond(R_); }
  [[nodiscard]] Eigen::Matrix4d matrix() const;
  [[nodiscard]] Se3 inverse() const { return {R_.transpose(), -(R_.transpose() * t_)}; }
  [[nodiscard]] Se3 operator*(const Se3& other) const { return {R_ * other.R_, R_ * other.t_ + t_}; }
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return R_ * p + t_; }
  /// Logarithm (t, ω), the inverse of exp for rotations below π.
  [[nodiscard]] Vector6d log() const;
  /// Ad such that T exp(ξ) T⁻¹ = exp(Ad ξ).
  [[nodiscard]] Matrix6d adjoint() const;
  /// The rotation brought back to orthonormal; call after long products.
  [[nodiscard]] Se3 normalized() const;
  /// Rotation angle, radians in [0, π].
  [[nodiscard]] double angle() const { return so3_log(R_).norm(); }
  /// No NaN or infinity, and a rotation within 1e-3 of orthonormal with determinant +1.
  [[nodiscard]] bool is_valid() const;

 private:
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
};

/// Left Jacobian of SE(3) in (t, ω) order (Barfoot 7.85–7.95), and its inverse; right Jacobian J_r(ξ) =
/// J_l(−ξ).
[[nodiscard]] Matrix6d se3_left_jacobian(const Vector6d& xi);
[[nodiscard]] Matrix6d se3_left_jacobian_inverse(const Vector6d& xi);

/// On the geodesic from a (s = 0) to b (s = 1): a · exp(s · log(a⁻¹ b)).
[[nodiscard]] Se3 interpolate(const Se3& a, const Se3& b, double s);

/// A single-precision copy for per-pixel loops.
struct Se3f {
  Eigen::Matrix3f R = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t = Eigen::Vector3f::Zero();
  Se3f() = default;
  explicit Se3f(const Se3& T) : R(T.rotation().cast<float>()), t(T.translation().cast<float>()) {}
  Eigen::Vector3f operator*(const Eigen::Vector3f& p) const { return R * p + t; }
};

}  // namespace loopsift
