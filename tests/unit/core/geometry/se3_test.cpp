// SPDX-License-Identifier: MIT
#include "core/geometry/se3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace loopsift {
namespace {

// Tangents of every size of rotation at which the formulas change their form.
std::vector<Vector6d> tangents() {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.8, 0.52).normalized(), t(0.7, -1.2, 2.1);
  std::vector<Vector6d> all;
  for (const double angle : {0.0, 1e-12, 1e-9, 0.9e-5, 1.1e-5, 0.9e-4, 1.1e-4, 1e-3, 0.049, 0.051, 0.5, 1.0,
                             2.0, 3.0, 3.14, 3.1415926}) {
    Vector6d xi;
    xi << t, angle * axis;
    all.push_back(xi);
  }
  return all;
}

double error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST(Se3, LogInvertsExp) {
  for (const Vector6d& xi : tangents()) {
    EXPECT_LT(error(Se3::exp(xi).log(), xi), 1e-7) << "at angle " << xi.tail<3>().norm();
  }
}

TEST(Se3, ExpInvertsLogAtHalfATurn) {
  const Se3 T(Eigen::Quaterniond(0, 0, 1, 0), Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(T.angle(), M_PI, 1e-12);
  EXPECT_LT(error(Se3::exp(T.log()).matrix(), T.matrix()), 1e-9);
}

TEST(Se3, ExpOfAQuarterTurnIsTheKnownScrew) {
  Vector6d xi;
  xi << 1, 0, 0, 0, 0, M_PI / 2;
  const Se3 T = Se3::exp(xi);
  EXPECT_LT(error(T * Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(2 / M_PI, 2 / M_PI + 1, 0)), 1e-12);
}

TEST(Se3, InverseAndProductAgreeWithMatrices) {
  const Se3 A = Se3::exp(tangents()[10]), B = Se3::exp(tangents()[12]);
  EXPECT_LT(error((A * B).matrix(), A.matrix() * B.matrix()), 1e-12);
  EXPECT_LT(error(A.inverse().matrix(), A.matrix().inverse()), 1e-12);
}

TEST(Se3, AdjointCarriesATangentToTheOtherSide) {
  const Se3 T = Se3::exp(tangents()[11]);
  Vector6d xi;
  xi << 0.3, -0.1, 0.2, 0.4, 0.2, -0.3;
  const Se3 left = T * Se3::exp(xi) * T.inverse(), right = Se3::exp(T.adjoint() * xi);
  EXPECT_LT(error(left.matrix(), right.matrix()), 1e-12);
}

TEST(Se3, LeftJacobianMatchesCentralDifferences) {
  // exp(ξ+δ) ≈ exp(J δ) exp(ξ)
  for (const Vector6d& xi : tangents()) {
    const double h = 1e-6;
    Matrix6d numeric;
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = h * Vector6d::Unit(k);
      const Se3 back = Se3::exp(xi).inverse();
      numeric.col(k) = ((Se3::exp(xi + d) * back).log() - (Se3::exp(xi - d) * back).log()) / (2 * h);
    }
    EXPECT_LT(error(se3_left_jacobian(xi), numeric), 1e-8) << "at angle " << xi.tail<3>().norm();
  }
}

TEST(Se3, LeftJacobianInverseInverts) {
  for (const Vector6d& xi : tangents()) {
    EXPECT_LT(error(se3_left_jacobian(xi) * se3_left_jacobian_inverse(xi), Matrix6d::Identity()), 1e-9)
        << "at angle " << xi.tail<3>().norm();
  }
}

TEST(Se3, So3LeftJacobianIsTheRotationBlockOfSe3) {
  for (const Vector6d& xi : tangents()) {
    const Eigen::Matrix3d J = so3_left_jacobian(xi.tail<3>());
    EXPECT_LT(error(J, se3_left_jacobian(xi).bottomRightCorner<3, 3>()), 1e-15);
    EXPECT_LT(error(J * so3_left_jacobian_inverse(xi.tail<3>()), Eigen::Matrix3d::Identity()), 1e-9);
  }
}

TEST(Se3, InterpolateMovesAtConstantTwist) {
  const Se3 a = Se3::exp(tangents()[10]), b = Se3::exp(tangents()[12]);
  EXPECT_LT(error(interpolate(a, b, 0).matrix(), a.matrix()), 1e-12);
  EXPECT_LT(error(interpolate(a, b, 1).matrix(), b.matrix()), 1e-9);
  const Se3 half = interpolate(a, b, 0.5);
  EXPECT_LT(error((a.inverse() * half).matrix(), (half.inverse() * b).matrix()), 1e-9);
}

TEST(Se3, FromMatrixRestoresARotation) {
  const Se3 T = Se3::exp(tangents()[11]);
  Eigen::Matrix4d rounded = T.matrix();
  rounded(0, 1) += 1e-4;
  const Se3 restored = Se3::from_matrix(rounded);
  EXPECT_LT(error(restored.rotation() * restored.rotation().transpose(), Eigen::Matrix3d::Identity()), 1e-12);
  EXPECT_LT(error(restored.matrix(), T.matrix()), 1e-3);
}

TEST(Se3, IsValidRefusesWhatIsNoRigidMotion) {
  EXPECT_TRUE(Se3().is_valid());
  EXPECT_FALSE(Se3(Eigen::Matrix3d(1.01 * Eigen::Matrix3d::Identity()), Eigen::Vector3d::Zero()).is_valid());
  EXPECT_FALSE(Se3(Eigen::Matrix3d(-Eigen::Matrix3d::Identity()), Eigen::Vector3d::Zero()).is_valid());
  EXPECT_FALSE(
      Se3(Eigen::Matrix3d(Eigen::Matrix3d::Identity()), Eigen::Vector3d(0, std::nan(""), 0)).is_valid());
}

}  // namespace
}  // namespace loopsift
