// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/g2o_input.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <utility>

namespace loopsift::tool {
namespace {

constexpr std::int64_t kSameFrame_ns = 5'000'000;

/// Where a vertex lies.
struct Place {
  FragmentId fragment;
  Se3 T_fragment_vertex;
};

/// The places of frames, by number and by time.
class Frames {
 public:
  explicit Frames(Span<const Fragment> fragments) {
    for (const Fragment& fragment : fragments)
      for (const FragmentFrame& frame : fragment.frames) {
        by_number_[frame.frame.value] = {fragment.id, frame.T_fragment_camera};
        by_time_[frame.timestamp_ns] = frame.frame.value;
      }
  }
  [[nodiscard]] const Place* numbered(int number) const {
    const auto at = by_number_.find(number);
    return at == by_number_.end() ? nullptr : &at->second;
  }
  [[nodiscard]] const Place* at_time(std::int64_t time_ns) const {
    auto best = by_time_.lower_bound(time_ns);
    if (best == by_time_.end() ||
        (best != by_time_.begin() && time_ns - std::prev(best)->first < best->first - time_ns))
      --best;
    return std::abs(best->first - time_ns) <= kSameFrame_ns ? numbered(best->second) : nullptr;
  }

 private:
  std::map<int, Place> by_number_;
  std::map<std::int64_t, int> by_time_;
};

Expected<std::vector<Place>> places_of(const PoseGraph& graph, const std::string& path,
                                       Span<const Fragment> fragments) {
  const bool timed = has_times(graph), whole = !timed && graph.nodes.size() == fragments.size();
  const Frames frames(fragments);
  std::vector<Place> places;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Place* place =
        timed ? frames.at_time(graph.nodes[n].timestamp_ns) : frames.numbered(static_cast<int>(n));
    if (whole) {
      places.push_back({FragmentId{static_cast<std::int32_t>(n)}, Se3()});
    } else if (place != nullptr) {
      places.push_back(*place);
    } else {
      return Error{ErrorCode::kFormat,
                   path + ": vertex " + std::to_string(n) + " (in order of id, from 0) is no frame of the " +
                       "recording that has depth and a pose" + (timed ? ", by its time in .times" : "") +
                       "; vertices are frames, or fragments where there are exactly " +
                       std::to_string(fragments.size())};
    }
  }
  return places;
}

// With T_a_b exp(e) in the edge, T_i_j = T_i_a T_a_b exp(e) T_b_j = T̂_i_j exp(Ad(T_j_b) e).
Loop carried(const Edge& edge, const Place& a, const Place& b) {
  Loop loop;
  loop.i = a.fragment;
  loop.j = b.fragment;
  loop.T_i_j = a.T_fragment_vertex * edge.T_a_b * b.T_fragment_vertex.inverse();
  const Matrix6d A = b.T_fragment_vertex.inverse().adjoint();
  loop.information = A.transpose() * edge.information * A;
  if (loop.i < loop.j) return loop;
  std::swap(loop.i, loop.j);
  loop.T_i_j = loop.T_i_j.inverse();
  const Matrix6d B = loop.T_i_j.adjoint();  // T exp(e) inverted is T⁻¹ exp(−Ad(T) e)
  loop.information = B.transpose() * loop.information * B;
  return loop;
}

}  // namespace

bool is_g2o(const std::string& path) {
  return path.size() > 4 && path.compare(path.size() - 4, 4, ".g2o") == 0;
}

bool has_times(const PoseGraph& graph) {
  return std::any_of(graph.nodes.begin(), graph.nodes.end(),
                     [](const Node& node) { return node.timestamp_ns != 0; });
}

Trajectory trajectory_of(const PoseGraph& graph) {
  Trajectory trajectory;
  trajectory.indexed = !has_times(graph);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const double time_s =
        trajectory.indexed ? static_cast<double>(n) : 1e-9 * static_cast<double>(graph.nodes[n].timestamp_ns);
    trajectory.poses.push_back({time_s, graph.T_map_node[n]});
  }
  return trajectory;
}

Expected<std::vector<Loop>> loops_of(const PoseGraph& graph, const std::string& path,
                                     Span<const Fragment> fragments) {
  const Expected<std::vector<Place>> places = places_of(graph, path, fragments);
  if (!places) return places.error();
  std::vector<Loop> loops;
  for (const Edge& edge : graph.loops) {
    const Place& a = (*places)[static_cast<std::size_t>(edge.a)];
    const Place& b = (*places)[static_cast<std::size_t>(edge.b)];
    if (a.fragment == b.fragment) continue;
    loops.push_back(carried(edge, a, b));
    loops.back().id.value = static_cast<std::int32_t>(loops.size()) - 1;
  }
  return loops;
}

}  // namespace loopsift::tool
