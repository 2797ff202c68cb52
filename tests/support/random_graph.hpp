// SPDX-License-Identifier: MIT
// Pose graphs with a known answer: a camera that walks round a circle more than once, drifting odometry, and
// true or false loops between fragments that saw the same place.
#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "core/posegraph/pose_graph.hpp"

namespace loopsift::test {

struct RandomGraphOptions {
  int fragments = 20;
  int nodes_per_fragment = 3;
  double laps = 2.0;  ///< rounds of the circle; loops need more than one
  double radius_m = 2.0;
  double odometry_sigma_m = 0.01;     ///< per edge, each axis
  double odometry_sigma_rad = 0.004;  ///< per edge, each axis
  double loop_sigma_m = 0.01;
  double loop_sigma_rad = 0.004;
  unsigned seed = 1;
};

/// The graph with odometry alone, the true poses, and the means to draw loops for it.
class RandomGraph {
 public:
  explicit RandomGraph(const RandomGraphOptions& options) : options_(options), random_(options.seed) {
    graph.first_node.push_back(0);
    for (int f = 0; f < options.fragments; ++f) add_fragment(FragmentId{f});
    odometry_information_ = information(options.odometry_sigma_m, options.odometry_sigma_rad);
    for (int n = 1; n < static_cast<int>(truth.size()); ++n) add_odometry(n);
  }

  /// A loop between two fragments: the truth with the loops' noise.
  Loop true_loop(int i, int j) {
    return make_loop(i, j, noise(options_.loop_sigma_m, options_.loop_sigma_rad));
  }
  /// A loop off the truth by about `offset_m` and half as many radians.
  Loop false_loop(int i, int j, double offset_m) { return make_loop(i, j, noise(offset_m, 0.5 * offset_m)); }
  /// `count` true loops between places seen a lap apart, spread over the path.
  std::vector<Loop> true_loops(int count) {
    std::vector<Loop> loops;
    const int lap = static_cast<int>(options_.fragments / options_.laps);
    for (int k = 0; k < count; ++k) {
      const int i = k * (options_.fragments - lap) / count;
      loops.push_back(true_loop(i, i + lap - 1 + k % 2));
    }
    return loops;
  }
  /// `count` false loops between random fragments.
  std::vector<Loop> false_loops(int count, double offset_m) {
    std::vector<Loop> loops;
    std::uniform_int_distribution<int> pick(0, options_.fragments - 1);
    while (static_cast<int>(loops.size()) < count) {
      const int i = pick(random_), j = pick(random_);
      if (j > i + 2) loops.push_back(false_loop(i, j, offset_m));
    }
    return loops;
  }
  /// Root mean square distance of the nodes of `estimate` from the truth; both start at the same pose.
  [[nodiscard]] double rmse_m(const PoseGraph& estimate) const {
    double sum = 0;
    for (std::size_t n = 0; n < truth.size(); ++n)
      sum += (estimate.T_map_node[n].translation() - truth[n].translation()).squaredNorm();
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }

  PoseGraph graph;
  std::vector<Se3> truth;  ///< T_map_node

 private:
  static Matrix6d information(double sigma_m, double sigma_rad) {
    const double t = 1.0 / (sigma_m * sigma_m), w = 1.0 / (sigma_rad * sigma_rad);
    return (Vector6d() << t, t, t, w, w, w).finished().asDiagonal();
  }
  Vector6d noise(double sigma_m, double sigma_rad) {
    std::normal_distribution<double> unit;
    Vector6d xi;
    for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? sigma_m : sigma_rad) * unit(random_);
    return xi;
  }
  [[nodiscard]] Se3 pose_on_path(int node) const {
    const int count = options_.fragments * options_.nodes_per_fragment;
    const double angle = 2.0 * 3.14159265358979 * options_.laps * node / count;
    const Eigen::Vector3d position(options_.radius_m * std::cos(angle), options_.radius_m * std::sin(angle),
                                   0.2 * std::sin(3.0 * angle));
    return {so3_exp({0, 0, angle}) * so3_exp({0.1 * std::sin(angle), 0, 0}), position};
  }
  void add_fragment(FragmentId fragment) {
    const int first = static_cast<int>(truth.size());
    for (int k = 0; k < options_.nodes_per_fragment; ++k) {
      truth.push_back(pose_on_path(first + k));
      const Se3& T_map_fragment = truth[static_cast<std::size_t>(first)];
      graph.nodes.push_back({fragment, T_map_fragment.inverse() * truth.back(), (first + k) * 100'000'000LL});
    }
    graph.first_node.push_back(static_cast<int>(truth.size()));
  }
  void add_odometry(int node) {
    if (graph.T_map_node.empty()) graph.T_map_node.push_back(truth[0]);
    const std::size_t n = static_cast<std::size_t>(node);
    const Se3 T_a_b = truth[n - 1].inverse() * truth[n] *
                      Se3::exp(noise(options_.odometry_sigma_m, options_.odometry_sigma_rad));
    graph.odometry.push_back({node - 1, node, T_a_b, odometry_information_, LoopId{}});
    graph.T_map_node.push_back((graph.T_map_node.back() * T_a_b).normalized());
  }
  Loop make_loop(int i, int j, const Vector6d& error) {
    Loop loop;
    loop.id = LoopId{next_loop_++};
    loop.i = FragmentId{i};
    loop.j = FragmentId{j};
    const auto node_i = static_cast<std::size_t>(graph.first_node[static_cast<std::size_t>(i)]);
    const auto node_j = static_cast<std::size_t>(graph.first_node[static_cast<std::size_t>(j)]);
    loop.T_i_j = truth[node_i].inverse() * truth[node_j] * Se3::exp(error);
    loop.information = information(options_.loop_sigma_m, options_.loop_sigma_rad);
    return loop;
  }

  RandomGraphOptions options_;
  std::mt19937 random_;
  Matrix6d odometry_information_;
  std::int32_t next_loop_ = 0;
};

}  // namespace loopsift::test
