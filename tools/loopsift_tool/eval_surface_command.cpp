// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "drivers/synth/mesh_io.hpp"
#include "tools/evaluation/point_ply.hpp"
#include "tools/evaluation/surface_error.hpp"
#include "tools/evaluation/trajectory_error.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

struct EvalSurfaceOptions {
  std::string gt_mesh, map, trajectory, gt_trajectory, json;
  AssociationOptions association;
};

Expected<SurfaceError> surface_error(const EvalSurfaceOptions& options) {
  const auto gt = read_trajectory(options.gt_trajectory);
  if (!gt.ok()) return gt.error();
  const auto est = read_trajectory(options.trajectory);
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
  return summarize_distances(std::move(*distances));
}

int eval_surface(const EvalSurfaceOptions& options) {
  const auto error = surface_error(options);
  if (!error.ok()) return fail(error.error());
  return show_figures({{"distance from map to surface, mean", "mean_m", error->mean_m, "m"},
                       {"  median", "median_m", error->median_m, "m"},
                       {"  95th percentile", "p95_m", error->p95_m, "m"},
                       {"map points", "points", error->points, ""}},
                      options.json);
}

}  // namespace

void add_eval_surface_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<EvalSurfaceOptions>();
  CLI::App* command = app.add_subcommand(
      "eval-surface", "Distance from a map to the true surface after aligning the trajectories");
  command
      ->add_option("--gt-mesh", options->gt_mesh, "true surface: OBJ or PLY, in the frame of --gt-trajectory")
      ->required();
  command->add_option("--map", options->map, "map points: PLY, in the frame of --trajectory")->required();
  command->add_option("--trajectory", options->trajectory, "estimated trajectory: TUM text or redwood .log")
      ->required();
  command->add_option("--gt-trajectory", options->gt_trajectory, "true trajectory: TUM text or redwood .log")
      ->required();
  command->add_flag("--by-index", options->association.by_index,
                    "pair the k-th pose with the k-th instead of by time (within 20 ms)");
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = eval_surface(*options); });
}

}  // namespace loopsift::tool
