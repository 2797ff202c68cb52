// SPDX-License-Identifier: MIT
// The map, put together from LOOPSIFT_FRAGMENT and LOOPSIFT_GRAPH in whatever order their chunks come.
// Surfels of a fragment never change; where the fragments lie is in the newest whole graph. Messages that
// make no sense are refused and change nothing. Allocates; one thread.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <loopsift/command_t.hpp>
#include <loopsift/fragment_t.hpp>
#include <loopsift/graph_t.hpp>
#include <map>
#include <memory>
#include <vector>

#include "loopsift/client/transform.hpp"

namespace loopsift::client {

/// One surfel in the map frame (X forward, Y left, Z up, at the start of the run).
struct Surfel {
  float x, y, z;     ///< metres
  float nx, ny, nz;  ///< unit normal, toward the camera that saw it
  float radius;      ///< metres
  float confidence;  ///< accumulated weight of the measurements
  std::uint8_t red, green, blue;
};

/// Moves the surfels of a fragment to the map, in the very operations that write map.ply: in camera axes (x
/// right, y down, z forward: the body's −Y, −Z, X) and single precision, so that every bit is the same.
class Placement {
 public:
  explicit Placement(const graph_fragment_t& place) {
    constexpr int kAxis[3] = {1, 2, 0};
    constexpr double kSign[3] = {-1, -1, 1};
    for (int row = 0; row < 3; ++row) {
      t_[row] = static_cast<float>(kSign[row] * place.t[kAxis[row]]);
      for (int col = 0; col < 3; ++col)
        R_[row][col] = static_cast<float>(kSign[row] * kSign[col] * place.R[3 * kAxis[row] + kAxis[col]]);
    }
  }
  [[nodiscard]] Surfel surfel(const fragment_t& c, int i) const {
    float p[3], n[3];
    for (int row = 0; row < 3; ++row) {
      p[row] = turned(row, c.x[i], c.y[i], c.z[i]) + t_[row];
      n[row] = turned(row, c.nx[i], c.ny[i], c.nz[i]);
    }
    return {p[2],        -p[0],           -p[1],    n[2],       -n[0],    -n[1],
            c.radius[i], c.confidence[i], c.red[i], c.green[i], c.blue[i]};
  }

 private:
  /// Of a point in body axes.
  [[nodiscard]] float turned(int row, float x, float y, float z) const {
    return R_[row][0] * -y + (R_[row][1] * -z + R_[row][2] * x);
  }
  float R_[3][3], t_[3];
};

/// A whole graph, all chunks of one version.
struct Graph {
  std::int32_t version = 0;  ///< 0: none has come
  std::int32_t epoch = 0;
  std::vector<graph_fragment_t> fragments;
  std::vector<graph_node_t> nodes;
  std::vector<graph_edge_t> edges;
};

class Map {
 public:
  static constexpr int kPerChunk = fragment_t::SURFELS_PER_CHUNK;
  static constexpr std::int32_t kMaxFragments = 65'535;
  static constexpr std::int32_t kMaxSurfels = 10'000'000;  ///< of one fragment
  static constexpr std::int32_t kMaxElements = 1'000'000;  ///< of one list of a graph

  /// False when the message makes no sense.
  bool add(const fragment_t& message);
  bool add(const graph_t& message);

  /// The newest graph that is whole.
  [[nodiscard]] const Graph& graph() const { return graph_; }
  /// Every surfel of every fragment in graph() is here.
  [[nodiscard]] bool complete() const;
  [[nodiscard]] std::int64_t chunks_received() const { return chunks_received_; }
  /// The surfels that are here, fragment by fragment, in the order of map.ply, each as visit(surfel,
  /// fragment). Without those of pieces that no loop has joined to the map yet: nobody knows where they lie.
  template <class Visitor>
  void for_each_surfel(Visitor visit) const {
    visit_surfels(visit, [](const graph_fragment_t& place) { return place.anchored != 0; });
  }
  /// With them, where the odometry puts them: all that map.ply has.
  template <class Visitor>
  void for_each_surfel_of_all_pieces(Visitor visit) const {
    visit_surfels(visit, [](const graph_fragment_t&) { return true; });
  }

  /// What is missing, as the objects of a RESEND command from `first_object` on: the newest graph, then the
  /// surfels of the fragments in graph(). Returns how many objects it set, at most 32.
  int add_missing(std::int32_t newest_graph_version, command_t* command) const;

 private:
  struct Fragment {
    std::int32_t surfel_count = 0;
    std::vector<std::unique_ptr<fragment_t>> chunks;
    std::size_t received = 0;
  };
  struct GraphParts {
    std::int32_t version = 0;
    std::vector<std::unique_ptr<graph_t>> chunks;
    std::size_t received = 0;
  };
  static std::int32_t chunk_count(std::int32_t elements, std::int32_t per_chunk) {
    return std::max(1, (elements + per_chunk - 1) / per_chunk);
  }
  static bool makes_sense(const fragment_t& message);
  static bool makes_sense(const graph_t& message);
  static bool want(std::int32_t object, std::int32_t chunk, command_t* command);
  void assemble_graph();
  template <class Visitor, class Choice>
  void visit_surfels(Visitor& visit, Choice wanted) const;

  Graph graph_;
  GraphParts parts_;  // of the newest version that was heard of
  std::map<std::int32_t, Fragment> fragments_;
  std::int64_t chunks_received_ = 0;
};

inline bool Map::makes_sense(const fragment_t& m) {
  if (m.fragment < 0 || m.fragment > kMaxFragments || m.surfel_count < 0 || m.surfel_count > kMaxSurfels ||
      m.chunk_count != chunk_count(m.surfel_count, kPerChunk) || m.chunk < 0 || m.chunk >= m.chunk_count ||
      m.n != std::min(kPerChunk, m.surfel_count - m.chunk * kPerChunk))
    return false;
  for (int i = 0; i < m.n; ++i) {
    const float all = m.x[i] + m.y[i] + m.z[i] + m.nx[i] + m.ny[i] + m.nz[i] + m.radius[i] + m.confidence[i];
    if (!std::isfinite(all)) return false;
  }
  return true;
}

inline bool Map::makes_sense(const graph_t& m) {
  const std::int32_t longest = std::max({m.fragment_count, m.node_count, m.edge_count});
  const auto in_chunk = [&m](std::int32_t count) {
    constexpr std::int32_t kMost = graph_t::ELEMENTS_PER_CHUNK;
    return std::clamp(count - m.chunk * kMost, 0, +kMost);
  };
  if (m.version < 1 || m.epoch < 0 || std::min({m.fragment_count, m.node_count, m.edge_count}) < 0 ||
      longest > kMaxElements || m.chunk_count != chunk_count(longest, graph_t::ELEMENTS_PER_CHUNK) ||
      m.chunk < 0 || m.chunk >= m.chunk_count || m.n_fragments != in_chunk(m.fragment_count) ||
      m.n_nodes != in_chunk(m.node_count) || m.n_edges != in_chunk(m.edge_count))
    return false;
  for (int k = 0; k < m.n_fragments; ++k) {
    double sum = 0;
    for (const double r : m.fragments[k].R) sum += r;
    for (const double t : m.fragments[k].t) sum += t;
    if (!std::isfinite(sum) || m.fragments[k].surfel_count < 0 || m.fragments[k].surfel_count > kMaxSurfels)
      return false;
  }
  for (int k = 0; k < m.n_nodes; ++k)
    if (!is_valid(make_transform(m.nodes[k].T_map_node.trans, m.nodes[k].T_map_node.quat)) ||
        !is_valid(make_transform(m.nodes[k].T_fragment_node.trans, m.nodes[k].T_fragment_node.quat)))
      return false;
  for (int k = 0; k < m.n_edges; ++k) {
    const graph_edge_t& edge = m.edges[k];
    if (edge.a < 0 || edge.b < 0 || edge.a >= m.node_count || edge.b >= m.node_count ||
        !is_valid(make_transform(edge.T_a_b.trans, edge.T_a_b.quat)))
      return false;
  }
  return true;
}

inline bool Map::add(const fragment_t& message) {
  if (!makes_sense(message)) return false;
  Fragment& fragment = fragments_[message.fragment];
  if (fragment.chunks.empty()) {
    fragment.surfel_count = message.surfel_count;
    fragment.chunks.resize(static_cast<std::size_t>(message.chunk_count));
  }
  if (fragment.surfel_count != message.surfel_count) return false;
  ++chunks_received_;
  auto& slot = fragment.chunks[static_cast<std::size_t>(message.chunk)];
  if (slot) return true;
  slot = std::make_unique<fragment_t>(message);
  ++fragment.received;
  return true;
}

inline bool Map::add(const graph_t& message) {
  if (!makes_sense(message) || message.version < parts_.version) return false;
  if (message.version > parts_.version) {
    parts_ = GraphParts{};
    parts_.version = message.version;
    parts_.chunks.resize(static_cast<std::size_t>(message.chunk_count));
  }
  if (parts_.chunks.size() != static_cast<std::size_t>(message.chunk_count)) return false;
  ++chunks_received_;
  auto& slot = parts_.chunks[static_cast<std::size_t>(message.chunk)];
  if (slot) return true;
  slot = std::make_unique<graph_t>(message);
  if (++parts_.received == parts_.chunks.size()) assemble_graph();
  return true;
}

inline void Map::assemble_graph() {
  graph_ = Graph{};
  graph_.version = parts_.version;
  graph_.epoch = parts_.chunks[0]->epoch;
  for (const auto& chunk : parts_.chunks) {
    std::copy_n(chunk->fragments, chunk->n_fragments, std::back_inserter(graph_.fragments));
    std::copy_n(chunk->nodes, chunk->n_nodes, std::back_inserter(graph_.nodes));
    std::copy_n(chunk->edges, chunk->n_edges, std::back_inserter(graph_.edges));
  }
}

inline bool Map::complete() const {
  if (graph_.version == 0) return false;
  for (std::size_t f = 0; f < graph_.fragments.size(); ++f) {
    const auto found = fragments_.find(static_cast<std::int32_t>(f));
    if (found == fragments_.end() || found->second.received < found->second.chunks.size()) return false;
  }
  return true;
}

template <class Visitor, class Choice>
void Map::visit_surfels(Visitor& visit, Choice wanted) const {
  for (const auto& [number, fragment] : fragments_) {
    if (static_cast<std::size_t>(number) >= graph_.fragments.size()) break;
    const graph_fragment_t& lies = graph_.fragments[static_cast<std::size_t>(number)];
    if (!wanted(lies)) continue;
    const Placement place(lies);
    for (const auto& chunk : fragment.chunks)
      for (int i = 0; chunk && i < chunk->n; ++i) visit(place.surfel(*chunk, i), number);
  }
}

/// Sets the bit of a chunk in the command; false when it has no room for another window.
inline bool Map::want(std::int32_t object, std::int32_t chunk, command_t* command) {
  constexpr std::int32_t kWindow = 8 * sizeof command->chunks[0];
  const std::int32_t first = chunk / kWindow * kWindow;
  int& n = command->n_objects;
  if (n == 0 || command->object[n - 1] != object || command->first_chunk[n - 1] != first) {
    if (n == static_cast<int>(std::size(command->object))) return false;
    command->object[n] = object;
    command->first_chunk[n] = first;
    std::fill(std::begin(command->chunks[n]), std::end(command->chunks[n]), std::uint8_t{0});
    ++n;
  }
  const std::int32_t bit = chunk - first;
  command->chunks[n - 1][bit / 8] =
      static_cast<std::uint8_t>(command->chunks[n - 1][bit / 8] | 1 << (bit % 8));
  return true;
}

inline int Map::add_missing(std::int32_t newest_graph_version, command_t* command) const {
  const int before = command->n_objects;
  if (parts_.version == 0 || parts_.version < newest_graph_version) {
    for (std::int32_t k = 0; k < 256; ++k) (void)want(command_t::GRAPH, k, command);
  } else {
    for (std::size_t k = 0; k < parts_.chunks.size(); ++k)
      if (!parts_.chunks[k]) (void)want(command_t::GRAPH, static_cast<std::int32_t>(k), command);
  }
  bool room = true;
  for (std::size_t f = 0; f < graph_.fragments.size() && room; ++f) {
    const auto number = static_cast<std::int32_t>(f);
    const auto found = fragments_.find(number);
    const bool known = found != fragments_.end();
    const std::int32_t surfels = known ? found->second.surfel_count : graph_.fragments[f].surfel_count;
    const std::int32_t chunks = chunk_count(surfels, kPerChunk);
    for (std::int32_t k = 0; k < chunks && room; ++k)
      if (!known || !found->second.chunks[static_cast<std::size_t>(k)]) room = want(number, k, command);
  }
  return command->n_objects - before;
}

}  // namespace loopsift::client
