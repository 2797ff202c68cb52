// SPDX-License-Identifier: MIT
// The newest pose graph on its way from the back thread to the publish thread, as the structs that its
// messages are made of. Capacity: GraphLimits, three times over; nodes and edges past it are left out and
// counted (loop edges come last, so they go first). Only put() allocates after construction.
#pragma once
#include <atomic>
#include <cstdint>
#include <loopsift/graph_t.hpp>

#include "core/base/arena.hpp"
#include "core/base/triple_buffer.hpp"
#include "core/fragment/fragment.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "firmware_app/publisher.hpp"

namespace loopsift {

/// A graph, in body axes.
struct GraphSnapshot {
  std::int64_t timestamp_ns = 0;
  std::int32_t version = 0;  ///< from 1; 0: there is none yet
  std::int32_t epoch = 0;
  std::int32_t fragment_count = 0, node_count = 0, edge_count = 0;
  Span<graph_fragment_t> fragments;
  Span<graph_node_t> nodes;
  Span<graph_edge_t> edges;

  /// Messages that it takes; at least 1.
  [[nodiscard]] std::int32_t chunk_count() const;
};

class GraphExchange {
 public:
  GraphExchange(const GraphLimits& limits, Arena& arena);

  /// Back thread. T_map_fragment has one pose for each of `fragments`; the graph may hold fewer: the others
  /// are anchored if the one before is, and tracking was not lost in between. Allocates.
  void put(const PoseGraph& graph, Span<const Fragment> fragments, Span<const Se3> T_map_fragment,
           std::int64_t timestamp_ns, std::int32_t epoch);

  /// Publish thread: takes over a newer graph where there is one.
  bool update() { return buffer_.update(); }
  [[nodiscard]] const GraphSnapshot& newest() const { return buffer_.readable(); }

  /// Allocates.
  [[nodiscard]] PoolFigures figures() const;

 private:
  TripleBuffer<GraphSnapshot> buffer_;
  std::int32_t version_ = 0;  // back thread
  std::size_t max_edges_;
  std::atomic<std::int64_t> high_water_{0}, left_out_{0};
};

/// Chunk k of a graph; utime and run are the caller's.
void fill(graph_t* message, const GraphSnapshot& graph, std::int32_t chunk);

}  // namespace loopsift
