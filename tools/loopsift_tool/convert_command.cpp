// SPDX-License-Identifier: MIT
// Recordings, trajectories, graphs and maps in other formats.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <string>

#include "core/posegraph/pose_graph.hpp"
#include "tools/evaluation/trajectory_formats.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/map_converter.hpp"
#include "tools/loopsift_tool/recording_writer.hpp"

namespace loopsift::tool {
namespace {

struct ConvertOptions {
  std::string from, to, format, from_format, edges, info, json;
  double rate_hz = 30;
  MapConversion map;
};

int convert_sequence(const ConvertOptions& options) {
  const SourceOptions as_it_is;
  const auto source = open_source(options.from, as_it_is);
  if (!source.ok()) return fail_to_open_source(source.error());
  const auto writer = open_recording_writer(options.format, options.to, (*source)->info());
  if (!writer.ok()) return fail(writer.error());
  const auto copied = copy_recording(**source, **writer);
  if (!copied.ok()) return fail(copied.error());
  return show_figures({{"frames written", "frames", copied->frames, ""},
                       {"frames that could not be read", "unusable", copied->unusable, ""}},
                      options.json);
}

int convert_trajectory(const ConvertOptions& options) {
  const auto format = trajectory_format(options.format);
  if (!format.ok()) return fail(format.error());
  std::optional<TrajectoryFormat> from_format;
  if (!options.from_format.empty()) {
    const auto named = trajectory_format(options.from_format);
    if (!named.ok()) return fail(named.error());
    from_format = *named;
  }
  const auto trajectory = read_any_trajectory(options.from, from_format);
  if (!trajectory.ok()) return fail(trajectory.error());
  const Status written = write_any_trajectory(options.to, *trajectory, *format, options.rate_hz);
  if (!written.ok()) return fail(written.error());
  return show_figures({{"poses written", "poses", trajectory->poses.size(), ""}}, options.json);
}

/// Vertices to STEM.poses.log, edges to STEM.log and STEM.info.
Status write_redwood_graph(const std::string& stem, const PoseGraph& graph) {
  const auto count = static_cast<int>(graph.nodes.size());
  std::vector<LogRecord> poses, edges;
  std::vector<InfoRecord> infos;
  poses.reserve(graph.nodes.size());
  for (int k = 0; k < count; ++k)
    poses.push_back({k, k, k + 1, graph.T_map_node[static_cast<std::size_t>(k)]});
  for (const auto* list : {&graph.odometry, &graph.loops})
    for (const Edge& edge : *list) {
      edges.push_back({edge.a, edge.b, count, edge.T_a_b});
      infos.push_back({edge.a, edge.b, count, edge.information});
    }
  if (Status s = write_log(stem + ".poses.log", poses); !s) return s;
  if (Status s = write_log(stem + ".log", edges); !s) return s;
  return write_info(stem + ".info", infos);
}

Expected<PoseGraph> read_redwood_graph(const ConvertOptions& options) {
  const auto poses = read_trajectory(options.from);
  if (!poses.ok()) return poses.error();
  const auto edges = read_log(options.edges);
  if (!edges.ok()) return edges.error();
  const auto infos = options.info.empty() ? Expected<std::vector<InfoRecord>>(std::vector<InfoRecord>())
                                          : read_info(options.info);
  if (!infos.ok()) return infos.error();
  if (!options.info.empty() && infos->size() != edges->size())
    return Error{ErrorCode::kUsage, options.info + ": has " + std::to_string(infos->size()) + " records, " +
                                        options.edges + " has " + std::to_string(edges->size())};
  PoseGraph graph;
  for (const StampedPose& pose : poses->poses) {
    Node node;
    const double time_s = poses->indexed ? pose.time_s / options.rate_hz : pose.time_s;
    node.timestamp_ns = std::llround(time_s * 1e9);
    graph.nodes.push_back(node);
    graph.T_map_node.push_back(pose.T_world_camera);
  }
  for (std::size_t k = 0; k < edges->size(); ++k) {
    const LogRecord& record = (*edges)[k];
    const auto count = static_cast<int>(graph.nodes.size());
    if (record.a < 0 || record.b < 0 || record.a >= count || record.b >= count || record.a == record.b)
      return Error{ErrorCode::kFormat, options.edges + ": record " + std::to_string(k + 1) + " joins " +
                                           std::to_string(record.a) + " and " + std::to_string(record.b) +
                                           "; there are " + std::to_string(count) + " poses"};
    Edge edge;
    edge.a = record.a;
    edge.b = record.b;
    edge.T_a_b = record.T;
    if (!infos->empty()) edge.information = (*infos)[k].information;
    (std::abs(edge.a - edge.b) == 1 ? graph.odometry : graph.loops).push_back(edge);
  }
  return graph;
}

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

int convert_graph(const ConvertOptions& options) {
  const bool from_g2o = ends_with(options.from, ".g2o");
  if (!from_g2o && options.edges.empty())
    return fail({ErrorCode::kUsage, "a graph from poses needs its edges, too: give --edges FILE.log"});
  const auto graph = from_g2o ? read_g2o(options.from) : read_redwood_graph(options);
  if (!graph.ok()) return fail(graph.error());
  const Status written = from_g2o ? write_redwood_graph(options.to, *graph) : write_g2o(options.to, *graph);
  if (!written.ok()) return fail(written.error());
  return show_figures({{"vertices", "vertices", graph->nodes.size(), ""},
                       {"edges", "edges", graph->odometry.size() + graph->loops.size(), ""}},
                      options.json);
}

int convert_points(const ConvertOptions& options) {
  const auto points = convert_map(options.from, options.to, options.map);
  if (!points.ok()) return fail(points.error());
  return show_figures({{"points", "points", *points, ""}}, options.json);
}

CLI::App* add_kind(CLI::App* command, const char* name, const char* about, ConvertOptions* options,
                   const char* from, const char* to) {
  CLI::App* kind = command->add_subcommand(name, about);
  kind->add_option("FROM", options->from, from)->required();
  kind->add_option("TO", options->to, to)->required();
  kind->add_option("--json", options->json, "write the figures to this file");
  return kind;
}

void add_rate(CLI::App* kind, ConvertOptions* options) {
  kind->add_option("--rate-hz", options->rate_hz, "turns frame numbers into seconds")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
}

}  // namespace

void add_convert_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ConvertOptions>();
  ConvertOptions* o = options.get();
  CLI::App* command =
      app.add_subcommand("convert", "Recordings, trajectories, graphs and maps in other formats");
  command->require_subcommand(1);

  CLI::App* sequence =
      add_kind(command, "sequence", "A recording in another format; colour goes through JPEG", o,
               "the recording: replay:FORMAT:PATH, openni2:FILE.oni or any other source that ends",
               "a folder, or a file for klg; made when missing");
  sequence
      ->add_option("--to", o->format,
                   "klg, tum, 7scenes, redwood or sun3d; not .oni, which only OpenNI2's own recorder "
                   "writes")
      ->required();
  sequence->callback([options, exit_code] { *exit_code = convert_sequence(*options); });

  CLI::App* trajectory = add_kind(command, "trajectory", "A trajectory in another format", o,
                                  "TUM, KITTI, EuRoC or redwood", "a file");
  trajectory->add_option("--to", o->format, "tum, kitti, euroc or redwood")->required();
  trajectory->add_option("--from-format", o->from_format, "by default told by the content");
  add_rate(trajectory, o);
  trajectory->callback([options, exit_code] { *exit_code = convert_trajectory(*options); });

  CLI::App* graph =
      add_kind(command, "graph", "A pose graph: g2o to redwood's .log and .info, or back", o,
               "FILE.g2o; or the poses of the vertices, redwood .log or TUM",
               "from g2o: the start of names (TO.poses.log, TO.log, TO.info); else the .g2o file");
  graph->add_option("--edges", o->edges, "edges between the poses, redwood .log");
  graph->add_option("--info", o->info, "their information, redwood .info; by default the identity");
  add_rate(graph, o);
  graph->callback([options, exit_code] { *exit_code = convert_graph(*options); });

  CLI::App* map = add_kind(command, "map", "The points of a binary PLY without normals, or as text", o,
                           "a PLY file", "a PLY file");
  map->add_flag("--no-normals", o->map.drop_normals, "leave out nx ny nz");
  map->add_flag("--ascii", o->map.text, "as text");
  map->callback([options, exit_code] { *exit_code = convert_points(*options); });
}

}  // namespace loopsift::tool
