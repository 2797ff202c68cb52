// SPDX-License-Identifier: MIT
// Rigid transforms as the messages have them, without a library for it. T_a_b maps points of frame b to frame
// a. Metres; quaternions (w, x, y, z) of length 1.
#pragma once
#include <array>
#include <cmath>

namespace loopsift::client {

using Vector3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;

[[nodiscard]] inline Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

[[nodiscard]] inline Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Quaternion turned = multiply(multiply(q, {0, v[0], v[1], v[2]}), {q[0], -q[1], -q[2], -q[3]});
  return {turned[1], turned[2], turned[3]};
}

struct Transform {
  Vector3 trans{};
  Quaternion quat{1, 0, 0, 0};

  [[nodiscard]] Vector3 operator*(const Vector3& p) const {
    const Vector3 turned = rotate(quat, p);
    return {turned[0] + trans[0], turned[1] + trans[1], turned[2] + trans[2]};
  }
  [[nodiscard]] Transform operator*(const Transform& other) const {
    return {*this * other.trans, multiply(quat, other.quat)};
  }
  [[nodiscard]] Transform inverse() const {
    const Quaternion back{quat[0], -quat[1], -quat[2], -quat[3]};
    const Vector3 p = rotate(back, trans);
    return {{-p[0], -p[1], -p[2]}, back};
  }
  /// About Z, −π to π: the heading of a body with X forward and Z up.
  [[nodiscard]] double yaw() const {
    return std::atan2(2 * (quat[0] * quat[3] + quat[1] * quat[2]),
                      1 - 2 * (quat[2] * quat[2] + quat[3] * quat[3]));
  }
};

/// From the members `trans` and `quat` (or `pos` and `orientation`) of any of the messages.
[[nodiscard]] inline Transform make_transform(const double (&trans)[3], const double (&quat)[4]) {
  return {{trans[0], trans[1], trans[2]}, {quat[0], quat[1], quat[2], quat[3]}};
}

/// Numbers throughout, and a rotation.
[[nodiscard]] inline bool is_valid(const Transform& T) {
  double norm = 0;
  for (const double q : T.quat) norm += q * q;
  return std::isfinite(T.trans[0]) && std::isfinite(T.trans[1]) && std::isfinite(T.trans[2]) &&
         std::abs(norm - 1) < 1e-3;
}

/// Between a (s = 0) and b (s = 1): straight in position, spherical (slerp) in rotation.
[[nodiscard]] inline Transform interpolate(const Transform& a, const Transform& b, double s) {
  Transform result;
  for (std::size_t i = 0; i < 3; ++i) result.trans[i] = a.trans[i] + s * (b.trans[i] - a.trans[i]);
  double dot = 0;
  for (std::size_t i = 0; i < 4; ++i) dot += a.quat[i] * b.quat[i];
  const double sign = dot < 0 ? -1 : 1;  // the shorter way round
  const double angle = std::acos(std::min(1.0, std::abs(dot)));
  const bool small = angle < 1e-6;
  const double from = small ? 1 - s : std::sin((1 - s) * angle) / std::sin(angle);
  const double to = sign * (small ? s : std::sin(s * angle) / std::sin(angle));
  double norm = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    result.quat[i] = from * a.quat[i] + to * b.quat[i];
    norm += result.quat[i] * result.quat[i];
  }
  for (double& q : result.quat) q /= std::sqrt(norm);
  return result;
}

}  // namespace loopsift::client
