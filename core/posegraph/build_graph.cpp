// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>

#include "core/posegraph/graph_check.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {
namespace {

// Adds to `covariance` (of a motion that ends at frame `from`) the single motions from there to frame `to`:
// each carried into the last frame by the adjoint (right perturbation).
void extend_covariance(Span<const FragmentFrame> frames, std::size_t from, std::size_t to,
                       Matrix6d* covariance) {
  const Matrix6d A0 = (frames[to].T_fragment_camera.inverse() * frames[from].T_fragment_camera).adjoint();
  *covariance = A0 * *covariance * A0.transpose();
  for (std::size_t k = from + 1; k <= to; ++k) {
    const Matrix6d A = (frames[to].T_fragment_camera.inverse() * frames[k].T_fragment_camera).adjoint();
    *covariance += A * frames[k].information.inverse() * A.transpose();
  }
}

// Frame numbers of a fragment's keyframes: evenly spread from the first.
std::size_t keyframe(const Fragment& fragment, std::size_t k, std::size_t count) {
  return k * fragment.frames.size() / count;
}

std::size_t keyframe_count(const Fragment& fragment, int keyframes) {
  return std::min(fragment.frames.size(), static_cast<std::size_t>(keyframes));
}

// The edge from the last keyframe of `previous` to the first frame of `fragment`.
Edge link(const Fragment& previous, const Fragment& fragment, int keyframes, int last_node) {
  const std::size_t count = keyframe_count(previous, keyframes);
  const std::size_t last = keyframe(previous, count - 1, count);
  const Se3 T_odom_last = previous.T_odom_fragment * previous.frames[last].T_fragment_camera;
  const std::size_t end = previous.frames.size() - 1;
  Matrix6d covariance = Matrix6d::Zero();
  extend_covariance(previous.frames, last, end, &covariance);
  const Se3 T_odom_end = previous.T_odom_fragment * previous.frames[end].T_fragment_camera;
  const Matrix6d A = (fragment.T_odom_fragment.inverse() * T_odom_end).adjoint();
  covariance = A * covariance * A.transpose() + fragment.frames[0].information.inverse();
  return {last_node, last_node + 1, T_odom_last.inverse() * fragment.T_odom_fragment, covariance.inverse(),
          LoopId{}};
}

}  // namespace

bool joined(const PoseGraph& graph, int a, int b) {
  std::vector<int> part(graph.T_map_node.size());
  find_parts(graph, part);
  return part[static_cast<std::size_t>(a)] == part[static_cast<std::size_t>(b)];
}

std::vector<bool> anchored_fragments(const PoseGraph& graph) {
  std::vector<int> part(graph.T_map_node.size());
  find_parts(graph, part);
  std::vector<bool> anchored(static_cast<std::size_t>(graph.fragment_count()));
  for (std::size_t f = 0; f < anchored.size(); ++f)
    anchored[f] = part[static_cast<std::size_t>(graph.first_node[f])] == 0;
  return anchored;
}

void append_fragment(const Fragment* previous, const Fragment& fragment, int keyframes, PoseGraph* graph) {
  assert((previous == nullptr) == graph->nodes.empty());
  if (previous == nullptr) graph->first_node.assign(1, 0);
  Se3 T_map_fragment = fragment.T_odom_fragment;
  if (previous != nullptr) {
    const Se3 T_map_previous = graph->T_map_fragment(previous->id);
    T_map_fragment = T_map_previous * previous->T_odom_fragment.inverse() * fragment.T_odom_fragment;
    if (fragment.joined_to_previous) {
      const int last_node = static_cast<int>(graph->nodes.size()) - 1;
      const Edge edge = link(*previous, fragment, keyframes, last_node);
      T_map_fragment = graph->T_map_node.back() * edge.T_a_b;
      graph->odometry.push_back(edge);
    }
  }
  const std::size_t count = keyframe_count(fragment, keyframes);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t f = keyframe(fragment, k, count);
    const FragmentFrame& frame = fragment.frames[f];
    const int node = static_cast<int>(graph->nodes.size());
    graph->nodes.push_back({fragment.id, frame.T_fragment_camera, frame.timestamp_ns});
    graph->T_map_node.push_back(T_map_fragment * frame.T_fragment_camera);
    if (k == 0) continue;
    const std::size_t before = keyframe(fragment, k - 1, count);
    Matrix6d covariance = Matrix6d::Zero();
    extend_covariance(fragment.frames, before, f, &covariance);
    const Se3 T = fragment.frames[before].T_fragment_camera.inverse() * frame.T_fragment_camera;
    graph->odometry.push_back({node - 1, node, T, covariance.inverse(), LoopId{}});
  }
  graph->first_node.push_back(static_cast<int>(graph->nodes.size()));
}

}  // namespace loopsift
