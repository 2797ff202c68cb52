// SPDX-License-Identifier: MIT
#include "core/posegraph/edge_error.hpp"

#include "core/posegraph/graph_check.hpp"

#include <gtest/gtest.h>

#include <random>

namespace loopsift {
namespace {

Vector6d random_tangent(std::mt19937* random, double metres, double radians) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vector6d xi;
  for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? metres : radians) * unit(*random);
  return xi;
}

// Column k of the derivative by a perturbation on the right, by central differences.
template <class Error>
Matrix6d numeric_jacobian(const Error& error) {
  constexpr double kStep = 1e-6;
  Matrix6d J;
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = kStep * Vector6d::Unit(k);
    J.col(k) = (error(Se3::exp(step)) - error(Se3::exp(-step))) / (2.0 * kStep);
  }
  return J;
}

TEST(EdgeError, IsZeroWhereThePosesAgreeWithTheMeasurement) {
  std::mt19937 random(1);
  const Se3 T_map_a = Se3::exp(random_tangent(&random, 3, 1)),
            T_a_b = Se3::exp(random_tangent(&random, 1, 1));
  EXPECT_LT(edge_error(T_a_b.inverse(), T_map_a, T_map_a * T_a_b).norm(), 1e-12);
}

TEST(EdgeError, JacobiansMatchNumericDifferences) {
  std::mt19937 random(2);
  for (const double error_size : {1e-7, 1e-3, 0.3, 2.0}) {
    const Se3 T_map_a = Se3::exp(random_tangent(&random, 5, 1.5));
    const Se3 T_a_b = Se3::exp(random_tangent(&random, 2, 1.0));
    const Se3 T_map_b = T_map_a * T_a_b * Se3::exp(random_tangent(&random, error_size, error_size));
    const Se3 T_b_a = T_a_b.inverse();
    const EdgeLinearization edge = linearize_edge(T_b_a, T_map_a, T_map_b);
    const Matrix6d J_a =
        numeric_jacobian([&](const Se3& step) { return edge_error(T_b_a, T_map_a * step, T_map_b); });
    const Matrix6d J_b =
        numeric_jacobian([&](const Se3& step) { return edge_error(T_b_a, T_map_a, T_map_b * step); });
    EXPECT_LT((edge.J_b - J_b).cwiseAbs().maxCoeff(), 1e-7) << "error of size " << error_size;
    EXPECT_LT((-edge.J_b * edge.adjoint_ba - J_a).cwiseAbs().maxCoeff(), 1e-7)
        << "error of size " << error_size;
    EXPECT_LT((edge.error - edge_error(T_b_a, T_map_a, T_map_b)).norm(), 1e-14);
  }
}

TEST(SquareRootInformation, GivesTheSameChi2) {
  std::mt19937 random(3);
  Matrix6d A;
  for (int k = 0; k < 6; ++k) A.col(k) = random_tangent(&random, 10, 100);
  const Matrix6d information = A * A.transpose();
  Matrix6d S;
  ASSERT_TRUE(square_root_information(information, &S));
  EXPECT_LT((S.transpose() * S - information).norm(), 1e-9 * information.norm());
}

TEST(SquareRootInformation, TakesWhatKnowsNothingOfSomeDirections) {
  Matrix6d S;
  ASSERT_TRUE(square_root_information(Matrix6d::Zero(), &S));
  EXPECT_EQ(S.norm(), 0.0);
  const Vector6d v = (Vector6d() << 1, 2, 3, 4, 5, 6).finished();
  ASSERT_TRUE(square_root_information(v * v.transpose(), &S));
  EXPECT_LT((S.transpose() * S - v * v.transpose()).norm(), 1e-10);
}

TEST(SquareRootInformation, RefusesWhatIsNoInformation) {
  Matrix6d S, information = Matrix6d::Identity();
  information(2, 2) = -1.0;
  EXPECT_FALSE(square_root_information(information, &S));
  information = Matrix6d::Identity();
  information(0, 1) = 0.5;
  EXPECT_FALSE(square_root_information(information, &S));
  information(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(square_root_information(information, &S));
}

}  // namespace
}  // namespace loopsift
