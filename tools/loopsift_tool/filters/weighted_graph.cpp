// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace loopsift::tool {
namespace {

double chi2_of(const Edge& edge, const PoseGraph& graph) {
  return edge_chi2(edge, graph.T_map_node[static_cast<std::size_t>(edge.a)],
                   graph.T_map_node[static_cast<std::size_t>(edge.b)]);
}

std::vector<double> mapped(const std::function<double(double)>& function, const std::vector<double>& from) {
  std::vector<double> to(from.size());
  std::transform(from.begin(), from.end(), to.begin(), function);
  return to;
}

}  // namespace

Expected<WeightedGraph> WeightedGraph::make(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                            WeightPer per) {
  WeightedGraph weighted;
  weighted.graph_ = odometry_graph;
  weighted.graph_.loops.clear();
  weighted.T_start_node_ = odometry_graph.T_map_node;
  const int fragments = odometry_graph.fragment_count();
  for (const Loop& loop : loops) {
    if (!loop.i.valid() || !loop.j.valid() || loop.i == loop.j || loop.i.value >= fragments ||
        loop.j.value >= fragments)
      return Error{ErrorCode::kUsage, "loop " + std::to_string(loop.id.value) + " joins fragments " +
                                          std::to_string(loop.i.value) + " and " +
                                          std::to_string(loop.j.value) + "; the graph has fragments 0 to " +
                                          std::to_string(fragments - 1)};
    std::vector<Edge> edges;
    append_frame_loops(odometry_graph, loop, &edges);
    weighted.add_loop(edges, loop.id, per);
  }
  return weighted;
}

void WeightedGraph::add_loop(const std::vector<Edge>& edges, LoopId id, WeightPer per) {
  const std::size_t loop = ids_.size();
  ids_.push_back(id);
  if (per == WeightPer::kLoop) {
    terms_.push_back({loop, edges});
  } else {
    for (const Edge& edge : edges) terms_.push_back({loop, {edge}});
  }
  terms_of_loop_.push_back(per == WeightPer::kLoop ? 1 : static_cast<int>(edges.size()));
}

void WeightedGraph::keep_terms(const std::vector<bool>& keep) {
  std::vector<Term> kept;
  for (std::size_t k = 0; k < terms_.size(); ++k)
    if (keep[k]) kept.push_back(std::move(terms_[k]));
  terms_ = std::move(kept);
}

Status WeightedGraph::solve_weighted(const std::vector<double>& factors) {
  graph_.loops.clear();
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (factors[k] == 0.0) continue;
    for (Edge edge : terms_[k].edges) {
      edge.information *= factors[k];
      graph_.loops.push_back(edge);
    }
  }
  SolveOptions options;
  options.max_iterations = 50;
  options.accept_iteration_limit = true;
  options.time_limit_s = 600.0;
  ++solves_;
  const SolveSummary summary = solve(options, &graph_);
  if (!summary.converged) return Error{ErrorCode::kNumeric, "a filter's pose graph: " + summary.message};
  return {};
}

std::vector<double> WeightedGraph::term_chi2() const {
  std::vector<double> chi2(terms_.size(), 0.0);
  for (std::size_t k = 0; k < terms_.size(); ++k)
    for (const Edge& edge : terms_[k].edges) chi2[k] += chi2_of(edge, graph_);
  return chi2;
}

double WeightedGraph::odometry_chi2() const {
  double chi2 = 0;
  for (const Edge& edge : graph_.odometry) chi2 += chi2_of(edge, graph_);
  return chi2;
}

FilterResult WeightedGraph::finish(const std::vector<double>& weights, double accept) {
  FilterResult result;
  result.weights.assign(ids_.size(), 0.0);
  for (std::size_t k = 0; k < terms_.size(); ++k) result.weights[terms_[k].loop] += weights[k];
  for (std::size_t loop = 0; loop < ids_.size(); ++loop) {
    result.weights[loop] /= terms_of_loop_[loop];
    if (result.weights[loop] >= accept) result.accepted.push_back(ids_[loop]);
  }
  result.graph = std::move(graph_);
  result.solves = solves_;
  return result;
}

Expected<std::vector<double>> alternate(const RobustCost& robust, int max_rounds, WeightedGraph* graph) {
  constexpr double kRelativeDecrease = 1e-8;
  double previous = HUGE_VAL;
  for (int round = 0; round < max_rounds; ++round) {
    const std::vector<double> chi2 = graph->term_chi2();
    double total = graph->odometry_chi2();
    for (const double term_cost : mapped(robust.cost, chi2)) total += term_cost;
    if (previous - total <= kRelativeDecrease * total) break;
    previous = total;
    if (Status status = graph->solve_weighted(mapped(robust.factor, chi2)); !status.ok())
      return status.error();
  }
  return mapped(robust.weight, graph->term_chi2());
}

RobustCost cauchy_cost(double scale) {
  const double c2 = scale * scale;
  RobustCost robust;
  robust.weight = [c2](double chi2) { return c2 / (c2 + chi2); };
  robust.factor = robust.weight;
  robust.cost = [c2](double chi2) { return c2 * std::log1p(chi2 / c2); };
  return robust;
}

Expected<FilterResult> finish_with(const std::vector<bool>& chosen, WeightedGraph* graph) {
  const std::vector<double> weights(chosen.begin(), chosen.end());
  graph->restart();
  if (Status status = graph->solve_weighted(weights); !status.ok()) return status.error();
  return graph->finish(weights, 0.5);
}

}  // namespace loopsift::tool
