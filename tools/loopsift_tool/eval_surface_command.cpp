// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "drivers/synth/mesh_io.hpp"
#include "tools/evaluation/point_ply.hpp"
#include "tools/evaluation/surface_error.hpp"
#include "tools/evaluation/trajectory_error.hpp"
#include "tools/evaluation/trajectory_formats.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

struct EvalSurfaceOptions {
  std::string gt_mesh, map, trajectory, gt_trajectory, json;
  AssociationOptions association;
  double within_m = 0.05;
};

struct SurfaceFigures {
  SurfaceError map_to_surface;
  double completeness = 0;
};

constexpr float kSampleSpacing_m = 0.02F;
constexpr std::size_t kMaxSamples = 500000;

Expected<SurfaceFigures> surface_error(const EvalSurfaceOptions& options) {
  const auto gt = read_any_trajectory(options.gt_trajectory);
  if (!gt.ok()) return gt.error();
  const auto est = read_any_trajectory(options.trajectory);
  if (!est.ok()) return est.error();
  const auto pairs = associate(*gt, *est, options.association);
  if (!pairs.ok()) return pairs.error();
  const auto mesh = read_mesh(options.gt_mesh);
  if (!mesh.ok()) return mesh.error();
  auto points = read_ply_points(options.map);
  if (!points.ok()) return points.error();

  const Se3f T_gt_est(align(*pairs));
  for (Eigen::Vector3f& p : *points) p = T_gt_est * p;
  auto distances = distances_to_mesh(*points, mesh->vertices, mesh->triangles);
  if (!distances.ok()) return distances.error();
  const auto summary = summarize_distances(std::move(*distances));
  if (!summary.ok()) return summary.error();
  const auto samples = sample_mesh(mesh->vertices, mesh->triangles, kSampleSpacing_m, kMaxSamples);
  if (!samples.ok()) return samples.error();
  const auto share = completeness(*samples, *points, static_cast<float>(options.within_m));
  if (!share.ok()) return share.error();
  return SurfaceFigures{*summary, *share};
}

int eval_surface(const EvalSurfaceOptions& options) {
  const auto figures = surface_error(options);
  if (!figures.ok()) return fail(figures.error());
  const SurfaceError* error = &figures->map_to_surface;
  return show_figures(
      {{"distance from map to surface, mean", "mean_m", error->mean_m, "m"},
       {"  median", "median_m", error->median_m, "m"},
       {"  95th percentile", "p95_m", error->p95_m, "m"},
       {"map points", "points", error->points, ""},
       {"completeness: surface with a map point near", "completeness", figures->completeness, ""},
       {"  within", "completeness_within_m", options.within_m, "m"}},
      options.json);
}

}  // namespace

void add_eval_surface_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<EvalSurfaceOptions>();
  CLI::App* command = app.add_subcommand("eval-surface",
                                         "Distance from a map to the true surface, and how much of that the "
                                         "map covers, after aligning the trajectories");
  command
      ->add_option("--gt-mesh", options->gt_mesh, "true surface: OBJ or PLY, in the frame of --gt-trajectory")
      ->required();
  command->add_option("--map", options->map, "map points: PLY, in the frame of --trajectory")->required();
  command
      ->add_option("--trajectory", options->trajectory, "estimated trajectory: TUM, KITTI, EuRoC or redwood")
      ->required();
  command
      ->add_option("--gt-trajectory", options->gt_trajectory, "true trajectory: TUM, KITTI, EuRoC or redwood")
      ->required();
  command->add_flag("--by-index", options->association.by_index,
                    "pair the k-th pose with the k-th instead of by time (within 20 ms)");
  command
      ->add_option(
          "--within", options->within_m,
          "metres in which a place of the true surface must have a map point to count as complete; what "
          "the camera never saw counts as missing")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = eval_surface(*options); });
}

}  // namespace loopsift::tool
