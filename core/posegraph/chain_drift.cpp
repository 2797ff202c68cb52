// SPDX-License-Identifier: MIT
#include "core/posegraph/chain_drift.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

constexpr double kMost_m = 1.0;  // further off is not worth trying from an estimate

// Mean variances per axis along a chain.
struct Variances {
  double translation = 0, rotation = 0;
  void add(const Edge& edge) {
    const Matrix6d covariance = edge.information.inverse();
    translation += covariance.topLeftCorner<3, 3>().trace() / 3;
    rotation += covariance.bottomRightCorner<3, 3>().trace() / 3;
  }
  // NaN and infinite covariances included.
  [[nodiscard]] float drift_m(double distance_m) const {
    const double drift = std::sqrt(translation + rotation * distance_m * distance_m);
    return static_cast<float>(drift < kMost_m ? drift : kMost_m);
  }
};

}  // namespace

std::vector<float> drift_to_newest(const PoseGraph& graph) {
  std::vector<float> drift(static_cast<std::size_t>(graph.fragment_count()), static_cast<float>(kMost_m));
  if (drift.empty()) return drift;
  const Eigen::Vector3d newest = graph.T_map_fragment(FragmentId{graph.fragment_count() - 1}).translation();
  drift.back() = 0;
  Variances sum;
  std::size_t edge = graph.odometry.size();
  int node = graph.first_node[drift.size() - 1];
  for (; edge > 0 && graph.odometry[edge - 1].b > node; --edge) {
  }
  for (std::size_t f = drift.size() - 1; f-- > 0;) {
    for (const int first = graph.first_node[f]; node > first; --node, --edge) {
      if (edge == 0 || graph.odometry[edge - 1].b != node) return drift;  // the chain ends here
      sum.add(graph.odometry[edge - 1]);
    }
    const FragmentId id{static_cast<std::int32_t>(f)};
    drift[f] = sum.drift_m((graph.T_map_fragment(id).translation() - newest).norm());
  }
  return drift;
}

}  // namespace loopsift
