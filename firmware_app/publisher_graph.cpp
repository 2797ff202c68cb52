// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_graph.hpp"

#include <algorithm>
#include <vector>

#include "firmware_app/publisher_messages.hpp"

namespace loopsift {
namespace {

constexpr std::int32_t kPerChunk = graph_t::ELEMENTS_PER_CHUNK;

std::array<GraphSnapshot, 3> carve(const GraphLimits& limits, Arena& arena) {
  std::array<GraphSnapshot, 3> slots;
  for (GraphSnapshot& slot : slots) {
    slot.fragments =
        arena.carve<graph_fragment_t>("publisher/graph", static_cast<std::size_t>(limits.max_fragments));
    slot.nodes = arena.carve<graph_node_t>("publisher/graph", static_cast<std::size_t>(limits.max_nodes));
    slot.edges = arena.carve<graph_edge_t>("publisher/graph", static_cast<std::size_t>(limits.max_edges));
  }
  return slots;
}

void fill_place(graph_fragment_t* out, const Fragment& fragment, const Se3& T_map_fragment, bool anchored) {
  const Se3 T = exactly_in_body_axes(T_map_fragment);
  out->first_frame_ns = fragment.frames.empty() ? 0 : fragment.frames[0].timestamp_ns;
  out->surfel_count = static_cast<std::int32_t>(fragment.surfels.size());
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) out->R[3 * row + col] = T.rotation()(row, col);
    out->t[row] = T.translation()[row];
  }
  out->anchored = anchored;
}

void fill_node(graph_node_t* out, const Node& node, const Se3& T_map_node) {
  out->utime = node.timestamp_ns / 1000;
  out->fragment = node.fragment.value;
  fill(&out->T_fragment_node, node.T_fragment_node);
  fill(&out->T_map_node, T_map_node);
}

void fill_edge(graph_edge_t* out, const Edge& edge) {
  out->a = edge.a;
  out->b = edge.b;
  out->loop = edge.loop.value;
  fill(&out->T_a_b, edge.T_a_b);
  const Matrix6d information = in_body_axes(edge.information);
  int k = 0;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) out->information[k++] = information(row, col);
}

/// Elements of a list that chunk k holds.
std::int32_t copied(std::int32_t count, std::int32_t chunk) {
  return std::clamp<std::int32_t>(count - chunk * kPerChunk, 0, kPerChunk);
}

/// Chunk k of a list to an array of kPerChunk, the rest zero.
template <class T>
void copy_chunk(Span<T> list, std::int32_t count, std::int32_t chunk, T* out) {
  const std::int32_t n = copied(count, chunk);
  if (n > 0) std::copy_n(list.data() + static_cast<std::size_t>(chunk) * kPerChunk, n, out);
  std::fill(out + n, out + kPerChunk, T{});
}

}  // namespace

std::int32_t GraphSnapshot::chunk_count() const {
  const std::int32_t longest = std::max({fragment_count, node_count, edge_count, 1});
  return (longest + kPerChunk - 1) / kPerChunk;
}

GraphExchange::GraphExchange(const GraphLimits& limits, Arena& arena)
    : buffer_(carve(limits, arena)), max_edges_(static_cast<std::size_t>(limits.max_edges)) {}

void GraphExchange::put(const PoseGraph& graph, Span<const Fragment> fragments,
                        Span<const Se3> T_map_fragment, std::int64_t timestamp_ns, std::int32_t epoch) {
  GraphSnapshot& slot = buffer_.writable();
  const std::size_t places = std::min({fragments.size(), T_map_fragment.size(), slot.fragments.size()});
  const std::size_t nodes = std::min(graph.nodes.size(), slot.nodes.size());
  const std::vector<bool> known = anchored_fragments(graph);
  bool anchored = true;
  for (std::size_t f = 0; f < places; ++f) {
    anchored = f < known.size() ? known[f] : anchored && fragments[f].joined_to_previous;
    fill_place(&slot.fragments[f], fragments[f], T_map_fragment[f], anchored);
  }
  for (std::size_t n = 0; n < nodes; ++n) fill_node(&slot.nodes[n], graph.nodes[n], graph.T_map_node[n]);
  std::size_t edges = 0;
  std::int64_t left_out = 0;
  for (const std::vector<Edge>* list : {&graph.odometry, &graph.loops}) {
    for (const Edge& edge : *list) {
      const bool has_nodes = edge.a < static_cast<int>(nodes) && edge.b < static_cast<int>(nodes);
      if (has_nodes && edges < slot.edges.size()) {
        fill_edge(&slot.edges[edges++], edge);
      } else {
        ++left_out;
      }
    }
  }
  slot.timestamp_ns = timestamp_ns;
  slot.version = ++version_;
  slot.epoch = epoch;
  slot.fragment_count = static_cast<std::int32_t>(places);
  slot.node_count = static_cast<std::int32_t>(nodes);
  slot.edge_count = static_cast<std::int32_t>(edges);
  high_water_.store(static_cast<std::int64_t>(edges) + left_out, std::memory_order_relaxed);
  left_out_.store(left_out, std::memory_order_relaxed);
  buffer_.publish();
}

PoolFigures GraphExchange::figures() const {
  return {"publisher/graph edges", static_cast<std::int64_t>(max_edges_),
          std::min(high_water_.load(), static_cast<std::int64_t>(max_edges_)), left_out_.load()};
}

void fill(graph_t* message, const GraphSnapshot& graph, std::int32_t chunk) {
  message->version = graph.version;
  message->epoch = graph.epoch;
  message->fragment_count = graph.fragment_count;
  message->node_count = graph.node_count;
  message->edge_count = graph.edge_count;
  message->chunk_count = graph.chunk_count();
  message->chunk = chunk;
  message->n_fragments = copied(graph.fragment_count, chunk);
  message->n_nodes = copied(graph.node_count, chunk);
  message->n_edges = copied(graph.edge_count, chunk);
  copy_chunk(graph.fragments, graph.fragment_count, chunk, message->fragments);
  copy_chunk(graph.nodes, graph.node_count, chunk, message->nodes);
  copy_chunk(graph.edges, graph.edge_count, chunk, message->edges);
}

}  // namespace loopsift
