// SPDX-License-Identifier: MIT
// Graduated non-convexity with truncated least squares: min over x of Σ_odometry χ² + Σ_loops min(χ², c̄²), by
// a surrogate that is convex for small μ and the truncated cost for μ → ∞. The odometry is trusted, as in the
// paper's pose graph experiments. Rounds of (i) poses at given weights, (ii) weights at given poses (eq. 14),
// (iii) μ ← 1.4 μ, from all weights 1 and μ = c̄² / (2 χ²_max − c̄²) (remark 5), until all weights are 0 or 1.
// The paper solves (i) to the global optimum (SE-Sync); here from the last round's poses.
#include <algorithm>
#include <cmath>

#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {
namespace {

double gnc_weight(double chi2, double bound, double mu) {
  if (chi2 >= (mu + 1.0) / mu * bound) return 0.0;
  if (chi2 <= mu / (mu + 1.0) * bound) return 1.0;
  return std::sqrt(bound * mu * (mu + 1.0) / chi2) - mu;
}

bool is_binary(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0.0 || w == 1.0; });
}

}  // namespace

Expected<FilterResult> run_gnc_tls(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                   const GncOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kLoop);
  if (!graph.ok()) return graph.error();
  const double bound = options.noise_bound_squared;
  std::vector<double> weights(loops.size(), 1.0);
  if (Status status = graph->solve_weighted(weights); !status.ok()) return status.error();
  std::vector<double> chi2 = graph->term_chi2();
  const double largest = chi2.empty() ? 0.0 : *std::max_element(chi2.begin(), chi2.end());
  if (largest <= bound) return graph->finish(weights, options.accept_weight);  // no loop is out of bounds

  double mu = bound / (2.0 * largest - bound);
  for (int round = 0; round < options.max_rounds; ++round, mu *= options.mu_factor) {
    const std::vector<double> before = weights;
    std::transform(chi2.begin(), chi2.end(), weights.begin(),
                   [&](double value) { return gnc_weight(value, bound, mu); });
    if (is_binary(weights) && weights == before) break;
    if (Status status = graph->solve_weighted(weights); !status.ok()) return status.error();
    chi2 = graph->term_chi2();
  }
  return graph->finish(weights, options.accept_weight);
}

}  // namespace loopsift::tool
