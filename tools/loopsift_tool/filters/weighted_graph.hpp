// SPDX-License-Identifier: MIT
// The pose graph under loops that carry weights, and the alternation that most filters share.
#pragma once
#include <functional>
#include <vector>

#include "tools/loopsift_tool/filters/filter.hpp"

namespace loopsift::tool {

/// What one weight belongs to.
enum class WeightPer {
  kLoop,  ///< a loop: all its edges together, their χ² summed
  kEdge,  ///< an edge of the graph
};

/// A graph whose loop edges' information is scaled by one factor per term, a loop or an edge. Starts at the
/// given poses with every factor 1.
class WeightedGraph {
 public:
  /// Errors: a loop between fragments that the graph does not have.
  [[nodiscard]] static Expected<WeightedGraph> make(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                    WeightPer per);

  /// Optimises the poses at the given factors of the terms' information. A solve that stops at its iteration
  /// limit counts: the next one goes on from there.
  [[nodiscard]] Status solve_weighted(const std::vector<double>& factors);
  /// χ² of each term at the present poses, with its own information (factor 1).
  [[nodiscard]] std::vector<double> term_chi2() const;
  /// χ² of the odometry's edges at the present poses.
  [[nodiscard]] double odometry_chi2() const;
  [[nodiscard]] std::size_t term_count() const { return terms_.size(); }

  /// Back to the poses that it was made with.
  void restart() { graph_.T_map_node = T_start_node_; }
  /// Leaves only the terms that are marked; the weight of the others is 0 from now on.
  void keep_terms(const std::vector<bool>& keep);

  /// Hands over the poses, with the weight of each loop, the mean of its terms', and which loops have at
  /// least `accept`.
  [[nodiscard]] FilterResult finish(const std::vector<double>& weights, double accept);

 private:
  struct Term {
    std::size_t loop;  // its place in the order given
    std::vector<Edge> edges;
  };
  void add_loop(const std::vector<Edge>& edges, LoopId id, WeightPer per);

  PoseGraph graph_;
  std::vector<Se3> T_start_node_;
  std::vector<LoopId> ids_;
  std::vector<Term> terms_;
  std::vector<int> terms_of_loop_;  // as made, by the loop's place
  int solves_ = 0;
};

/// A term's weight, the factor on its information and its cost, as functions of its χ².
struct RobustCost {
  std::function<double(double)> weight;
  std::function<double(double)> factor;
  std::function<double(double)> cost;  ///< the weight's prior included, at the best weight
};

/// Alternates between weights and poses until the total cost, odometry's χ² and the terms' costs, falls by
/// less than a hundred-millionth, or max_rounds. Returns the weights at the end.
[[nodiscard]] Expected<std::vector<double>> alternate(const RobustCost& robust, int max_rounds,
                                                      WeightedGraph* graph);

/// c² log(1 + χ²/c²): Cauchy's loss. Weight and factor are c² / (c² + χ²).
[[nodiscard]] RobustCost cauchy_cost(double scale);

/// Least squares from the graph's first poses with the marked loops alone; for filters that choose. The graph
/// has one term per loop, and none was left out.
[[nodiscard]] Expected<FilterResult> finish_with(const std::vector<bool>& chosen, WeightedGraph* graph);

}  // namespace loopsift::tool
