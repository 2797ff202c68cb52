// SPDX-License-Identifier: MIT
#include "core/posegraph/fast_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/posegraph/edge_error.hpp"
#include "core/posegraph/graph_check.hpp"

namespace loopsift {
namespace {

// Damping by the diagonal of H. Small at first: the soft modes of a chain of n edges are n² below the
// diagonal, and damping them costs iterations; a step that overshoots raises it fast.
constexpr double kInitialDamping = 1e-9;
constexpr double kMaxDamping = 1e6;
constexpr double kNegligibleCost = 1e-12;  // of ½ χ²: where rounding is all that is left

const Se3& pose(const Span<Se3>& poses, int node) { return poses[static_cast<std::size_t>(node)]; }

double sum_chi2(const std::vector<Edge>& edges, const Span<Se3>& poses) {
  double sum = 0;
  for (const Edge& edge : edges) sum += edge_chi2(edge, pose(poses, edge.a), pose(poses, edge.b));
  return sum;
}

}  // namespace

SolverWorkspace::SolverWorkspace(Arena* arena, const SolverLimits& limits)
    : limits_(limits), cholesky_(arena, limits.max_nodes, limits.max_blocks) {
  const auto nodes = static_cast<std::size_t>(limits.max_nodes);
  unknown_ = arena->carve<int>("posegraph/solver", nodes);
  gradient_ = arena->carve<Vector6d>("posegraph/solver", nodes);
  step_ = arena->carve<Vector6d>("posegraph/solver", nodes);
  start_ = arena->carve<Se3>("posegraph/solver", nodes);
  trial_ = arena->carve<Se3>("posegraph/solver", nodes);
}

// One solve.
class FastSolver {
 public:
  FastSolver(const SolveOptions& options, SolverWorkspace* workspace, PoseGraph* graph)
      : options_(options), w_(*workspace), graph_(*graph), poses_(graph->T_map_node) {}

  SolveSummary run() {
    SolveSummary summary;
    if (!prepare(&summary)) return summary;
    iterate(&summary);
    if (!summary.converged) std::copy_n(w_.start_.data(), poses_.size(), poses_.data());
    summary.odometry_chi2 = sum_chi2(graph_.odometry, poses_);
    summary.loop_chi2 = sum_chi2(graph_.loops, poses_);
    return summary;
  }

 private:
  bool prepare(SolveSummary* summary);
  void number_unknowns();
  void iterate(SolveSummary* summary);
  [[nodiscard]] bool has_to_give_up(double current, double damping, SolveSummary* summary) const;
  void linearize();
  void add_edge(const Edge& edge);
  [[nodiscard]] bool try_step(double damping, double* trial_cost, double* predicted);
  [[nodiscard]] double cost(const Span<Se3>& poses) const {
    return 0.5 * (sum_chi2(graph_.odometry, poses) + sum_chi2(graph_.loops, poses));
  }
  [[nodiscard]] bool out_of_time() const {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
    return elapsed.count() > options_.time_limit_s;
  }
  [[nodiscard]] int unknown(int node) const { return w_.unknown_[static_cast<std::size_t>(node)]; }
  // Says why the numbers did not work out: the malformed node or edge if there is one.
  [[nodiscard]] std::string numeric_failure() const {
    const Status status = check_graph(graph_);
    return status.ok() ? "the solve failed: no step reduces the cost" : status.error().message;
  }

  const SolveOptions& options_;
  SolverWorkspace& w_;
  PoseGraph& graph_;
  Span<Se3> poses_;
  int unknowns_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

bool FastSolver::prepare(SolveSummary* summary) {
  if (const Status status = check_structure(graph_); !status.ok()) {
    summary->message = status.error().message;
    return false;
  }
  if (poses_.size() > static_cast<std::size_t>(w_.limits_.max_nodes)) {
    summary->message = "the graph has " + std::to_string(poses_.size()) +
                       " nodes, the solver's workspace takes " + std::to_string(w_.limits_.max_nodes);
    return false;
  }
  std::copy_n(poses_.data(), poses_.size(), w_.start_.data());
  number_unknowns();
  w_.cholesky_.begin(unknowns_);
  for (const std::vector<Edge>* edges : {&graph_.odometry, &graph_.loops})
    for (const Edge& edge : *edges)
      if (unknown(edge.a) >= 0 && unknown(edge.b) >= 0)
        w_.cholesky_.connect(unknown(edge.a), unknown(edge.b));
  if (w_.cholesky_.analyze()) return true;
  summary->message = "the graph needs more than the " + std::to_string(w_.limits_.max_blocks) +
                     " blocks of the solver's workspace";
  return false;
}

void FastSolver::number_unknowns() {
  find_parts(graph_, w_.unknown_);
  for (std::size_t node = 0; node < poses_.size(); ++node) {
    const bool fixed = w_.unknown_[node] == static_cast<int>(node);
    w_.unknown_[node] = fixed ? -1 : unknowns_++;
  }
}

bool FastSolver::has_to_give_up(double current, double damping, SolveSummary* summary) const {
  if (!std::isfinite(current) || damping > kMaxDamping)
    summary->message = numeric_failure();
  else if (out_of_time())
    summary->message = "the solve ran past its limit of " + std::to_string(options_.time_limit_s) + " s";
  else if (summary->iterations == options_.max_iterations && !options_.accept_iteration_limit)
    summary->message =
        "the solve did not converge in " + std::to_string(options_.max_iterations) + " iterations";
  return !summary->message.empty();
}

// Levenberg–Marquardt with the gain-controlled damping of Nielsen (Damping parameter in Marquardt's method,
// 1999), as Ceres has it.
void FastSolver::iterate(SolveSummary* summary) {
  double damping = kInitialDamping, growth = 2.0;
  double current = summary->initial_cost = summary->final_cost = cost(poses_);
  bool moved = true, done = unknowns_ == 0;  // moved: H and the gradient belong to other poses
  while (!done) {
    if (has_to_give_up(current, damping, summary)) return;
    if (summary->iterations == options_.max_iterations) break;
    ++summary->iterations;
    if (moved) linearize();
    double trial_cost = 0, predicted = 0;
    const bool solved = try_step(damping, &trial_cost, &predicted);
    const double gain = current - trial_cost;
    done = solved && std::max(std::abs(gain), predicted) <=
                         options_.relative_cost_tolerance * current + kNegligibleCost;
    moved = solved && gain > 0;
    if (moved) {
      std::copy_n(w_.trial_.data(), poses_.size(), poses_.data());
      current = summary->final_cost = trial_cost;
      damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain / predicted - 1.0, 3));
      growth = 2.0;
    } else {
      damping *= growth;
      growth *= 2.0;
    }
  }
  summary->converged = true;
}

void FastSolver::linearize() {
  w_.cholesky_.clear();
  std::fill_n(w_.gradient_.data(), unknowns_, Vector6d::Zero());
  for (const Edge& edge : graph_.odometry) add_edge(edge);
  for (const Edge& edge : graph_.loops) add_edge(edge);
}

// With J_a = −J_b Ad and M = J_bᵀ Λ J_b the edge adds M, Adᵀ M Ad and −M Ad to H; see edge_error.hpp.
void FastSolver::add_edge(const Edge& edge) {
  const EdgeLinearization at =
      linearize_edge(edge.T_a_b.inverse(), pose(poses_, edge.a), pose(poses_, edge.b));
  const Matrix6d weighted_J = edge.information * at.J_b;
  const Matrix6d M = at.J_b.transpose() * weighted_J;
  const Vector6d gradient_b = weighted_J.transpose() * at.error;
  const int a = unknown(edge.a), b = unknown(edge.b);
  if (b >= 0) {
    w_.cholesky_.add_diagonal(b, M);
    w_.gradient_[static_cast<std::size_t>(b)] += gradient_b;
  }
  if (a < 0) return;
  const Matrix6d M_Ad = M * at.adjoint_ba;
  w_.cholesky_.add_diagonal(a, at.adjoint_ba.transpose() * M_Ad);
  w_.gradient_[static_cast<std::size_t>(a)] -= at.adjoint_ba.transpose() * gradient_b;
  if (b >= 0) w_.cholesky_.add_off_diagonal(b, a, -M_Ad);
}

// The damped step (H + λ D) δ = −g, and what the quadratic model promises of it: ½ δᵀ (λ D δ − g).
bool FastSolver::try_step(double damping, double* trial_cost, double* predicted) {
  if (!w_.cholesky_.factorize(damping)) return false;
  const auto unknowns = static_cast<std::size_t>(unknowns_);
  for (std::size_t k = 0; k < unknowns; ++k) w_.step_[k] = -w_.gradient_[k];
  w_.cholesky_.solve(w_.step_);
  *predicted = 0;
  for (std::size_t k = 0; k < unknowns; ++k) {
    const Vector6d& step = w_.step_[k];
    const Vector6d damped = damping * w_.cholesky_.damping_scale(static_cast<int>(k)).cwiseProduct(step);
    *predicted += 0.5 * step.dot(damped - w_.gradient_[k]);
  }
  for (std::size_t node = 0; node < poses_.size(); ++node) {
    const int k = w_.unknown_[node];
    w_.trial_[node] =
        k < 0 ? poses_[node] : (poses_[node] * Se3::exp(w_.step_[static_cast<std::size_t>(k)])).normalized();
  }
  *trial_cost = cost(w_.trial_.first(poses_.size()));
  return std::isfinite(*trial_cost);
}

SolveSummary solve_fast(const SolveOptions& options, SolverWorkspace* workspace, PoseGraph* graph) {
  return FastSolver(options, workspace, graph).run();
}

}  // namespace loopsift
