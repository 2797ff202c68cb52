// SPDX-License-Identifier: MIT
// Switchable constraints with the linear switch function Ψ(s) = s (the paper's choice, eq. 7–9):
//
//     min over x, s:  Σ_odometry χ² + Σ_loop edges ( s² χ² + Ξ (1 − s)² )
//
// A switch stands in its own two terms only, so that its best value at given poses is in closed form,
// s = Ξ / (Ξ + χ²), and poses and switches are optimised in turn. The paper optimises them together by
// Gauss–Newton from s = 1, which has the same minima; where there are several, the one reached may differ.
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {

Expected<FilterResult> run_switchable_constraints(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                  const SwitchableConstraintsOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kEdge);
  if (!graph.ok()) return graph.error();
  const double xi = options.switch_information;
  RobustCost robust;
  robust.weight = [xi](double chi2) { return xi / (xi + chi2); };
  robust.factor = [xi](double chi2) { return (xi / (xi + chi2)) * (xi / (xi + chi2)); };
  robust.cost = [xi](double chi2) { return xi * chi2 / (xi + chi2); };  // both terms at that s
  Expected<std::vector<double>> switches = alternate(robust, options.max_rounds, &*graph);
  if (!switches.ok()) return switches.error();
  return graph->finish(*switches, options.accept_switch);
}

}  // namespace loopsift::tool
