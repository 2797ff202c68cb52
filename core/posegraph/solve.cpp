// SPDX-License-Identifier: MIT
// The only file that sees Ceres.
#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/heap_watch.hpp"
#include "core/posegraph/edge_error.hpp"
#include "core/posegraph/graph_check.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {
namespace {

using Parameters = std::array<double, 7>;  // quaternion x, y, z, w, then translation

Se3 to_pose(const double* p) {
  return {Eigen::Quaterniond(Eigen::Map<const Eigen::Quaterniond>(p)),
          Eigen::Map<const Eigen::Vector3d>(p + 4)};
}

void from_pose(const Se3& T, double* p) {
  Eigen::Map<Eigen::Quaterniond>{p} = T.quaternion().normalized();
  Eigen::Map<Eigen::Vector3d>{p + 4} = T.translation();
}

// T ← T exp(δ). Its "Jacobian" is the constant [I 0]: the cost functions differentiate by δ itself and leave
// the seventh column zero, so the product that Ceres forms is exact without the chain rule through the
// quaternion.
class Se3Manifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    from_pose(to_pose(x) * Se3::exp(Eigen::Map<const Vector6d>(delta)), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<Vector6d>{y_minus_x} = (to_pose(x).inverse() * to_pose(y)).log();
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

// S e with SᵀS = Λ, and its derivatives by the two ends' δ.
class EdgeCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  EdgeCost(const Edge& edge, const Matrix6d& S) : T_b_a_(edge.T_a_b.inverse()), S_(S) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Se3 T_map_a = to_pose(parameters[0]), T_map_b = to_pose(parameters[1]);
    Eigen::Map<Vector6d> weighted(residuals);
    if (jacobians == nullptr) {
      weighted = S_ * edge_error(T_b_a_, T_map_a, T_map_b);
      return weighted.allFinite();
    }
    const EdgeLinearization edge = linearize_edge(T_b_a_, T_map_a, T_map_b);
    weighted = S_ * edge.error;
    const Matrix6d J_b = S_ * edge.J_b;
    if (jacobians[0] != nullptr) write(-J_b * edge.adjoint_ba, jacobians[0]);
    if (jacobians[1] != nullptr) write(J_b, jacobians[1]);
    return weighted.allFinite() && J_b.allFinite();
  }

 private:
  static void write(const Matrix6d& J, double* out) {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> jacobian(out);
    jacobian.leftCols<6>() = J;
    jacobian.col(6).setZero();
  }
  Se3 T_b_a_;
  Matrix6d S_;
};

// The first node of each part that edges join.
std::vector<int> fixed_nodes(const PoseGraph& graph) {
  std::vector<int> first_of_part(graph.T_map_node.size()), fixed;
  find_parts(graph, first_of_part);
  for (int node = 0; node < static_cast<int>(first_of_part.size()); ++node)
    if (first_of_part[static_cast<std::size_t>(node)] == node) fixed.push_back(node);
  return fixed;
}

double sum_chi2(const std::vector<Edge>& edges, const std::vector<Se3>& T_map_node) {
  double sum = 0;
  for (const Edge& edge : edges)
    sum += edge_chi2(edge, T_map_node[static_cast<std::size_t>(edge.a)],
                     T_map_node[static_cast<std::size_t>(edge.b)]);
  return sum;
}

void build_problem(const PoseGraph& graph, std::vector<Parameters>* parameters, ceres::Manifold* manifold,
                   ceres::Problem* problem) {
  for (std::size_t k = 0; k < parameters->size(); ++k) {
    from_pose(graph.T_map_node[k], (*parameters)[k].data());
    problem->AddParameterBlock((*parameters)[k].data(), 7, manifold);
  }
  for (const std::vector<Edge>* edges : {&graph.odometry, &graph.loops})
    for (const Edge& edge : *edges) {
      Matrix6d S;
      if (!square_root_information(edge.information, &S)) continue;  // check_graph let none of these pass
      problem->AddResidualBlock(new EdgeCost(edge, S), nullptr,
                                (*parameters)[static_cast<std::size_t>(edge.a)].data(),
                                (*parameters)[static_cast<std::size_t>(edge.b)].data());
    }
  for (const int node : fixed_nodes(graph))
    problem->SetParameterBlockConstant((*parameters)[static_cast<std::size_t>(node)].data());
}

ceres::Solver::Options solver_options(const SolveOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Nearly Gauss–Newton at first: Ceres' own 1e4 damps the soft modes of a chain and doubles the iterations.
  ceres_options.initial_trust_region_radius = 1e9;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.function_tolerance = options.relative_cost_tolerance;
  ceres_options.gradient_tolerance = 1e-10;   // a start at the minimum ends on this,
  ceres_options.parameter_tolerance = 1e-14;  // all others on the cost
  ceres_options.max_solver_time_in_seconds = options.time_limit_s;
  ceres_options.num_threads = 1;
  ceres_options.logging_type = ceres::SILENT;
  return ceres_options;
}

std::string failure(const SolveOptions& options, const ceres::Solver::Summary& summary) {
  if (summary.termination_type == ceres::NO_CONVERGENCE &&
      summary.total_time_in_seconds >= options.time_limit_s)
    return "the solve ran past its limit of " + std::to_string(options.time_limit_s) + " s";
  if (summary.termination_type == ceres::NO_CONVERGENCE)
    return "the solve did not converge in " + std::to_string(options.max_iterations) + " iterations";
  return "the solve failed: " + summary.message;
}

bool usable(const SolveOptions& options, const ceres::Solver::Summary& summary) {
  if (summary.termination_type == ceres::CONVERGENCE) return true;
  return options.accept_iteration_limit && summary.termination_type == ceres::NO_CONVERGENCE &&
         summary.total_time_in_seconds < options.time_limit_s;
}

SolveSummary solve_checked(const SolveOptions& options, PoseGraph* graph) {
  std::vector<Parameters> parameters(graph->T_map_node.size());
  Se3Manifold manifold;  // outlives the problem, which does not own it
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  build_problem(*graph, &parameters, &manifold, &problem);
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(solver_options(options), &problem, &ceres_summary);

  SolveSummary summary;
  summary.iterations = std::max(0, static_cast<int>(ceres_summary.iterations.size()) - 1);
  summary.initial_cost = ceres_summary.initial_cost;
  summary.final_cost = ceres_summary.final_cost;
  summary.converged = usable(options, ceres_summary);
  std::vector<Se3> T_map_node(parameters.size());
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    T_map_node[k] = to_pose(parameters[k].data());
    summary.converged = summary.converged && T_map_node[k].is_valid();
  }
  for (const int node : fixed_nodes(*graph))  // to the last bit
    T_map_node[static_cast<std::size_t>(node)] = graph->T_map_node[static_cast<std::size_t>(node)];
  if (summary.converged)
    graph->T_map_node.swap(T_map_node);
  else
    summary.message = failure(options, ceres_summary);
  return summary;
}

}  // namespace

SolveSummary solve(const SolveOptions& options, PoseGraph* graph) {
  SolveSummary summary;
  if (const Status status = check_graph(*graph); !status.ok()) {
    summary.message = status.error().message;
    return summary;
  }
  if (graph->odometry.empty() && graph->loops.empty()) {
    summary.converged = true;  // nothing to move; Ceres calls an empty problem a failure
    return summary;
  }
  // The back thread has a bounded amount of memory; the graph is only written to when all has gone well.
  if (!within_fence([&] { summary = solve_checked(options, graph); }))
    summary.message = "the solve ran out of the memory allowed to it";
  summary.odometry_chi2 = sum_chi2(graph->odometry, graph->T_map_node);
  summary.loop_chi2 = sum_chi2(graph->loops, graph->T_map_node);
  return summary;
}

}  // namespace loopsift
