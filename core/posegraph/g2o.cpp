// SPDX-License-Identifier: MIT
// g2o's error is (t, q_xyz) of T̂⁻¹ T_a⁻¹ T_b, ours the logarithm (t, ω); near zero q_xyz = ω/2, so that
// Λ_ω = D Λ_q D with D = diag(1, 1, 1, ½, ½, ½).
#include <Eigen/Geometry>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "core/base/text_file.hpp"
#include "core/posegraph/graph_check.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift {
namespace {

Vector6d half_rotation() { return (Vector6d() << 1.0, 1.0, 1.0, 0.5, 0.5, 0.5).finished(); }

Error line_error(const std::string& path, int line, const std::string& what) {
  return {ErrorCode::kFormat, path + ", line " + std::to_string(line) + ": " + what};
}

// x y z qx qy qz qw. False unless seven finite numbers with a unit quaternion (to 1 %) follow.
bool read_pose(std::istringstream* in, Se3* T) {
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  if (!(*in >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w())) return false;
  if (!t.allFinite() || !(std::abs(q.norm() - 1.0) < 1e-2)) return false;
  *T = Se3(q, t);
  return true;
}

// The 21 upper-triangular terms, by rows.
bool read_information(std::istringstream* in, Matrix6d* information) {
  Matrix6d L;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) {
      if (!(*in >> L(row, col))) return false;
      L(col, row) = L(row, col);
    }
  const Vector6d D = half_rotation();
  *information = D.asDiagonal() * L * D.asDiagonal();
  Matrix6d S;
  return square_root_information(*information, &S);
}

bool at_end(std::istringstream* in) {
  std::string rest;
  return !(*in >> rest);
}

// What a file holds, by the file's own vertex ids.
struct Contents {
  std::map<int, Se3> vertices;
  std::vector<Edge> edges;
  std::vector<int> edge_lines;
};

Status read_line(const std::string& path, int number, const std::string& line, Contents* contents) {
  std::istringstream in(line);
  std::string tag;
  if (!(in >> tag) || tag[0] == '#' || tag == "FIX") return {};
  if (tag == "VERTEX_SE3:QUAT") {
    int id = -1;
    Se3 T;
    if (!(in >> id) || id < 0 || !read_pose(&in, &T) || !at_end(&in))
      return line_error(path, number,
                        "expected `VERTEX_SE3:QUAT id x y z qx qy qz qw` with a unit quaternion");
    if (!contents->vertices.emplace(id, T).second)
      return line_error(path, number, "vertex " + std::to_string(id) + " is there twice");
    return {};
  }
  if (tag == "EDGE_SE3:QUAT") {
    Edge edge;
    if (!(in >> edge.a >> edge.b) || edge.a == edge.b || !read_pose(&in, &edge.T_a_b))
      return line_error(path, number,
                        "expected `EDGE_SE3:QUAT i j x y z qx qy qz qw` with i ≠ j and a unit quaternion");
    if (!read_information(&in, &edge.information) || !at_end(&in))
      return line_error(
          path, number,
          "expected the 21 upper-triangular terms of a positive semi-definite information matrix");
    contents->edges.push_back(edge);
    contents->edge_lines.push_back(number);
    return {};
  }
  return line_error(path, number,
                    "'" + tag + "' is not understood; only VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX are read");
}

Expected<PoseGraph> to_graph(const std::string& path, const Contents& contents) {
  PoseGraph graph;
  std::map<int, int> node_of;
  for (const auto& [id, T] : contents.vertices) {
    const int node = static_cast<int>(graph.nodes.size());
    node_of[id] = node;
    graph.nodes.push_back({FragmentId{node}, Se3(), 0});
    graph.T_map_node.push_back(T);
    graph.first_node.push_back(node);
  }
  graph.first_node.push_back(static_cast<int>(graph.nodes.size()));
  for (std::size_t k = 0; k < contents.edges.size(); ++k) {
    Edge edge = contents.edges[k];
    const auto a = node_of.find(edge.a), b = node_of.find(edge.b);
    if (a == node_of.end() || b == node_of.end())
      return line_error(path, contents.edge_lines[k],
                        "the edge names vertex " + std::to_string(a == node_of.end() ? edge.a : edge.b) +
                            ", which the file does not have");
    edge.a = a->second;
    edge.b = b->second;
    const bool neighbours = std::abs(edge.a - edge.b) == 1;
    if (!neighbours) edge.loop = LoopId{static_cast<std::int32_t>(graph.loops.size())};
    (neighbours ? graph.odometry : graph.loops).push_back(edge);
  }
  return graph;
}

// The sidecar of times, one `id seconds` per line; a graph from elsewhere has none.
Status read_times(const std::string& path, const Contents& contents, PoseGraph* graph) {
  if (!std::ifstream(path)) return {};
  Expected<TextFile> file = TextFile::open(path);
  if (!file.ok()) return file.error();
  while (file->next()) {
    int id = -1;
    std::int64_t timestamp_ns = 0;
    const auto& words = file->words();
    if (words.size() != 2 || !parse_number(words[0], &id) || !parse_seconds(words[1], &timestamp_ns) ||
        contents.vertices.count(id) == 0)
      return file->error("expected `id seconds` of a vertex of the graph");
    const auto node = std::distance(contents.vertices.begin(), contents.vertices.find(id));
    graph->nodes[static_cast<std::size_t>(node)].timestamp_ns = timestamp_ns;
  }
  return {};
}

void write_pose(std::FILE* file, const Se3& T) {
  const Eigen::Vector3d& t = T.translation();
  const Eigen::Quaterniond q = T.quaternion().normalized();
  std::fprintf(file, " %.12g %.12g %.12g %.12g %.12g %.12g %.12g", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
               q.w());
}

void write_edge(std::FILE* file, const Edge& edge) {
  const Vector6d inverse_D = half_rotation().cwiseInverse();
  const Matrix6d L = inverse_D.asDiagonal() * edge.information * inverse_D.asDiagonal();
  std::fprintf(file, "EDGE_SE3:QUAT %d %d", edge.a, edge.b);
  write_pose(file, edge.T_a_b);
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) std::fprintf(file, " %.12g", L(row, col));
  std::fputc('\n', file);
}

Status close_file(std::FILE* file, const std::string& path) {
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed)
    return Error{ErrorCode::kIo, path + ": could not be written in full; is the disk full?"};
  return {};
}

}  // namespace

Status write_g2o(const std::string& path, const PoseGraph& graph) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) return Error{ErrorCode::kIo, path + ": cannot be opened for writing"};
  for (std::size_t k = 0; k < graph.T_map_node.size(); ++k) {
    std::fprintf(file, "VERTEX_SE3:QUAT %zu", k);
    write_pose(file, graph.T_map_node[k]);
    std::fputc('\n', file);
  }
  for (const Edge& edge : graph.odometry) write_edge(file, edge);
  for (const Edge& edge : graph.loops) write_edge(file, edge);
  if (Status status = close_file(file, path); !status.ok()) return status;

  const std::string times_path = path + ".times";
  file = std::fopen(times_path.c_str(), "w");
  if (file == nullptr) return Error{ErrorCode::kIo, times_path + ": cannot be opened for writing"};
  constexpr std::int64_t kSecond = 1'000'000'000;
  for (std::size_t k = 0; k < graph.nodes.size(); ++k) {
    const std::int64_t ns = graph.nodes[k].timestamp_ns;
    std::fprintf(file, "%zu %" PRId64 ".%09" PRId64 "\n", k, ns / kSecond, ns % kSecond);
  }
  return close_file(file, times_path);
}

Expected<PoseGraph> read_g2o(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened; is the path right?"};
  Contents contents;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number)
    if (Status status = read_line(path, number, line, &contents); !status.ok()) return status.error();
  if (contents.vertices.empty())
    return Error{ErrorCode::kFormat, path + ": holds no VERTEX_SE3:QUAT line; is it a 3D g2o graph?"};
  Expected<PoseGraph> graph = to_graph(path, contents);
  if (!graph.ok()) return graph;
  if (Status status = read_times(path + ".times", contents, &*graph); !status.ok()) return status.error();
  return graph;
}

}  // namespace loopsift
