// SPDX-License-Identifier: MIT
// The dense map posterior of a trajectory: the metric alone.
#include <CLI/CLI.hpp>
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
  bool full = false;
};

int show(const Expected<DmpFigures>& figures, const std::string& json) {
  if (!figures) return fail(figures.error());
  return show_figures({{"dense map posterior", "dmp", figures->dmp, "m^2"},
                       {"views", "views", figures->views, ""},
                       {"pixels with both depths", "valid_pixels", figures->valid_pixels, ""}},
                      json);
}

Expected<DmpFigures> reduced_dmp(FrameSource& source, const GivenOdometry& odometry,
                                 const OfflineMapOptions& options) {
  const auto map = OfflineMap::build(source, odometry, options);
  if (!map) return map.error();
  const BackEnd& back_end = (*map)->back_end(0);
  const PoseGraph& graph = back_end.odometry_graph();
  const std::vector<Se3> poses = fragment_poses(graph, graph.T_map_node);
  const MapScorer& scorer = back_end.scorer();
  return DmpFigures{scorer.score(poses, ScoreKind::kPlain).value, scorer.view_count(),
                    scorer.valid_pixels(poses)};
}

int dmp(const DmpOptions& options) {
  if (const Status valid = validate(options.map); !valid) return fail(valid.error());
  SourceOptions source_options;
  source_options.want_color = false;
  const auto source = open_source(options.source, source_options);
  if (!source) return fail_to_open_source(source.error());
  const auto odometry = GivenOdometry::open(options.trajectory, "");
  if (!odometry) return fail(odometry.error());
  if (!options.full) return show(reduced_dmp(**source, *odometry, options.map), options.json);
  const auto again = open_source(options.source, source_options);
  if (!again) return fail_to_open_source(again.error());
  FullDmpOptions full;
  full.fragment_frames = options.map.fragment_frames;
  return show(full_dmp(**source, **again, *odometry, full), options.json);
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
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = dmp(*options); });
}

}  // namespace loopsift::tool
