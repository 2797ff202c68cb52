// SPDX-License-Identifier: MIT
// The loop filters that others have published, on our pose graph, for comparison. In: the odometry's graph
// and proposed loops. Out: which loops each keeps, and the poses it ends with. Each takes its parameters from
// its paper by default. Desk code: allocates, one thread, deterministic.
//
// All start at the graph's own poses, the odometry's, and alternate between poses at given weights (solve())
// and weights at given poses, in closed form. A loop becomes several edges (append_frame_loops), which share
// its information. Switchable constraints and covariance scaling weigh each edge of the graph, as their
// papers do; the line process and GNC, which measure a loop against its correspondences and against the
// quantile of its χ², weigh the loop as a whole.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift::tool {

/// What a filter did with the loops.
struct FilterResult {
  std::vector<double> weights;   ///< of each loop in the order given, in [0, 1]; the mean of its edges'
  std::vector<LoopId> accepted;  ///< of weight at least the filter's bound, in the order given
  PoseGraph graph;               ///< final poses; its loops are the frame loops as last weighted
  int solves = 0;                ///< pose graph solves that it took
};

/// Every weight 0: the odometry.
[[nodiscard]] Expected<FilterResult> run_none(const PoseGraph& odometry_graph, Span<const Loop> loops);
/// Every weight 1: plain least squares.
[[nodiscard]] Expected<FilterResult> run_all(const PoseGraph& odometry_graph, Span<const Loop> loops);

/// Sünderhauf & Protzel, Switchable constraints for robust pose graph SLAM, IROS 2012.
struct SwitchableConstraintsOptions {
  double switch_information = 1.0;  ///< Ξ, of the prior that pulls every switch to 1; the paper's 1
  double accept_switch = 0.5;       ///< kept with a switch of at least this
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_switchable_constraints(
    const PoseGraph& odometry_graph, Span<const Loop> loops,
    const SwitchableConstraintsOptions& options = {});

/// Agarwal et al., Robust map optimization using dynamic covariance scaling, ICRA 2013.
struct DynamicCovarianceScalingOptions {
  double phi = 1.0;           ///< Φ; the paper's 1
  double accept_scale = 0.5;  ///< kept with a scale s of at least this
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_dynamic_covariance_scaling(
    const PoseGraph& odometry_graph, Span<const Loop> loops,
    const DynamicCovarianceScalingOptions& options = {});

/// Choi, Zhou & Koltun, Robust reconstruction of indoor scenes, CVPR 2015.
struct LineProcessOptions {
  double distance_m = 0.05;   ///< τ: μ = τ² κ, the cost of a loop whose partners are all that far apart
  double accept_line = 0.25;  ///< a loop below it is pruned before the last solve
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_line_process(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                      const LineProcessOptions& options = {});

/// Yang et al., Graduated non-convexity for robust spatial perception, RA-L 2020: truncated least squares.
struct GncOptions {
  double noise_bound_squared = 16.812;  ///< c̄², of χ²; the 0.99 quantile for six degrees of freedom
  double mu_factor = 1.4;               ///< μ grows by it each round; the paper's 1.4
  double accept_weight = 0.5;           ///< weights end near 0 or 1
  int max_rounds = 1000;
};
[[nodiscard]] Expected<FilterResult> run_gnc_tls(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                 const GncOptions& options = {});

/// A filter with the parameters of its paper, for tables.
struct NamedFilter {
  const char* name;    ///< as in tables and JSON
  const char* source;  ///< the paper; empty for none and all
  Expected<FilterResult> (*run)(const PoseGraph& odometry_graph, Span<const Loop> loops);
};
/// All of the above, in the order above.
[[nodiscard]] Span<const NamedFilter> published_filters();

}  // namespace loopsift::tool
