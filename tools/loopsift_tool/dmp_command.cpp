// SPDX-License-Identifier: MIT
// The dense map posterior of a trajectory: the metric alone.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/full_dmp.hpp"
#include "tools/loopsift_tool/offline_map.hpp"

namespace loopsift::tool {
namespace {

struct DmpOptions {
  std::string source, trajectory, json;
  OfflineMapOptions map;
  FullDmpOptions full_options;
  bool full = false, per_view = false;
};

nlohmann::ordered_json views_json(const std::vector<ViewDmp>& views) {
  auto json = nlohmann::ordered_json::array();
  for (const ViewDmp& view : views)
    json.push_back(
        {{"frame", view.frame}, {"fragment", view.fragment}, {"time_s", view.time_s}, {"dmp", view.dmp}});
  return json;
}

int show(const Expected<DmpFigures>& figures, const DmpOptions& options) {
  if (!figures) return fail(figures.error());
  const std::vector<Figure> table = {{"dense map posterior", "dmp", figures->dmp, "m^2"},
                                     {"views", "views", figures->views, ""},
                                     {"pixels with both depths", "valid_pixels", figures->valid_pixels, ""}};
  if (!options.per_view) return show_figures(table, options.json);
  if (const int exit_code = show_figures(table, ""); exit_code != kExitDone) return exit_code;
  std::printf("\n%8s %9s %12s %12s\n", "frame", "fragment", "time, s", "dmp, m^2");
  for (const ViewDmp& view : figures->per_view)
    std::printf("%8d %9d %12.3f %12.6f\n", view.frame, view.fragment, view.time_s, view.dmp);
  nlohmann::ordered_json json;
  for (const Figure& figure : table) json[figure.key] = figure.value;
  json["per_view"] = views_json(figures->per_view);
  const Status written = write_json(options.json, json);
  return written.ok() ? kExitDone : fail(written.error());
}

Expected<DmpFigures> reduced(FrameSource& source, const GivenOdometry& odometry,
                             const OfflineMapOptions& options, const HeatmapOptions& heatmaps) {
  const auto map = OfflineMap::build(source, odometry, options);
  if (!map) return map.error();
  const PoseGraph& graph = (*map)->back_end(0).odometry_graph();
  return reduced_dmp(**map, fragment_poses(graph, graph.T_map_node), heatmaps);
}

int dmp(const DmpOptions& options) {
  if (const Status valid = validate(options.map); !valid) return fail(valid.error());
  SourceOptions source_options;
  source_options.want_color = false;
  const auto source = open_source(options.source, source_options);
  if (!source) return fail_to_open_source(source.error());
  const auto odometry = GivenOdometry::open(options.trajectory, "");
  if (!odometry) return fail(odometry.error());
  if (!options.full)
    return show(reduced(**source, *odometry, options.map, options.full_options.heatmaps), options);
  const auto again = open_source(options.source, source_options);
  if (!again) return fail_to_open_source(again.error());
  FullDmpOptions full = options.full_options;
  full.fragment_frames = options.map.fragment_frames;
  return show(full_dmp(**source, **again, *odometry, full), options);
}

}  // namespace

void add_dmp_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<DmpOptions>();
  CLI::App* command =
      app.add_subcommand("dmp", "How badly the map of a trajectory predicts the depth that was measured");
  command->add_option("--source", options->source, "recording: replay:FORMAT:PATH or synth:SCENE")
      ->required();
  command
      ->add_option("--trajectory", options->trajectory,
                   "camera-to-world: TUM text (by time) or redwood .log (by frame number)")
      ->required();
  command->add_flag("--full", options->full,
                    "as published: all frames at full resolution, every surfel, 0.3 to 15 m. Takes long; "
                    "values do not compare with the reduced ones");
  command
      ->add_option("--fragment-frames", options->map.fragment_frames,
                   "frames that are fused rigidly together")
      ->capture_default_str();
  command
      ->add_option("--views", options->map.views, "frames per fragment that are scored, in the reduced form")
      ->capture_default_str();
  command
      ->add_option("--view-width", options->map.view_width,
                   "pixels that these frames are reduced to; values of different widths do not compare")
      ->capture_default_str();
  command->add_flag("--per-view", options->per_view, "each view's part, too");
  command->add_option(
      "--heatmap", options->full_options.heatmaps.folder,
      "a folder for pictures of the residual: of the reduced views, or with --full of the frames. White: map "
      "and measurement agree; red: the map is in front, blue: behind, full colour at 10 cm; grey: not "
      "predicted");
  command
      ->add_option("--heatmap-every", options->full_options.heatmaps.every,
                   "frames from one picture to the next")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = dmp(*options); });
}

}  // namespace loopsift::tool
