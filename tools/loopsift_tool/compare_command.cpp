// SPDX-License-Identifier: MIT
// The same loops through published filters and through ours, in one table; and how each holds up in a sweep.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "core/sifter/map_trial.hpp"
#include "drivers/synth/mesh_io.hpp"
#include "tools/evaluation/surface_error.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/comparison/sweep.hpp"
#include "tools/loopsift_tool/comparison/task_pool.hpp"
#include "tools/loopsift_tool/sift_arguments.hpp"

namespace loopsift::tool {
namespace {

using Json = nlohmann::ordered_json;

struct CompareOptions {
  SiftArguments arguments;
  TruthFiles truth;
  std::string gt_mesh, sweep_csv;
  SweepOptions sweep;
};

Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// Mean distance of the map to the true surface, the trajectories aligned.
Expected<double> surface_distance(const ContestInput& input, const std::vector<Se3>& T_map_fragment,
                                  const std::vector<PosePair>& pairs, const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> points;
  const Se3 T_gt_map = align(pairs);
  for (const Fragment& fragment : input.map->fragments()) {
    const Se3f T_gt_fragment(T_gt_map * T_map_fragment[fragment.id.index()]);
    const SurfelSpan& s = fragment.surfels;
    for (std::size_t k = 0; k < s.size(); ++k)
      points.push_back(T_gt_fragment * Eigen::Vector3f(s.x[k], s.y[k], s.z[k]));
  }
  auto distances = distances_to_mesh(points, mesh.vertices, mesh.triangles);
  if (!distances) return distances.error();
  const auto error = summarize_distances(std::move(*distances));
  if (!error) return error.error();
  return error->mean_m;
}

std::vector<Outcome> run_all_contestants(const ContestInput& input) {
  std::vector<Outcome> outcomes(contestants().size());
  std::vector<std::function<void()>> tasks;
  for (std::size_t c = 0; c < outcomes.size(); ++c)
    tasks.emplace_back([&, c] { outcomes[c] = contestants()[c].run(input); });
  run_tasks("filters done:", tasks);
  return outcomes;
}

Expected<Json> table(const ContestInput& input, const Truth& truth, const MapScorer& scorer,
                     const std::optional<TriangleMesh>& mesh) {
  const std::vector<Outcome> outcomes = run_all_contestants(input);
  Json rows = Json::array();
  for (std::size_t c = 0; c < outcomes.size(); ++c) {
    const Figures figures = judge(input, truth, outcomes[c]);
    if (truth.has_trajectory() && !figures.ate_rmse_m)
      return Error{ErrorCode::kFormat,
                   "--gt: fewer than 3 frames of the recording have a true pose; do the "
                   "two overlap in time?"};
    const std::vector<Se3> poses = fragment_poses(input.odometry, outcomes[c].T_map_node);
    Json row = {{"filter", contestants()[c].name},
                {"accepted", figures.accepted},
                {"precision", number(figures.precision)},
                {"recall", number(figures.recall)},
                {"ate_rmse_m", number(figures.ate_rmse_m)}};
    if (mesh) {
      const auto distance = surface_distance(input, poses, pose_pairs(input, truth, outcomes[c]), *mesh);
      if (!distance) return distance.error();
      row["surface_mean_m"] = *distance;
    }
    row["dmp"] = scorer.dmp(poses).value;
    row["wall_s"] = outcomes[c].wall_s;
    if (!outcomes[c].failure.empty()) row["failure"] = outcomes[c].failure;
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string text(const Json& row, const char* key, const char* format) {
  char number[32] = "-";
  if (row.contains(key) && row[key].is_number())
    std::snprintf(number, sizeof number, format, row[key].get<double>());
  return number;
}

void print_table(const Json& rows, const ContestInput& input) {
  std::printf("%zu loops, %zu of them true\n", input.loops.size(), input.true_ids.size());
  std::printf("%-28s %8s %9s %7s %9s %10s %10s %8s\n", "filter", "accepted", "precision", "recall", "ATE m",
              "surface m", "DMP m^2", "wall s");
  for (const Json& r : rows) {
    std::printf("%-28s %8d %9s %7s %9s %10s %10s %8s\n", r["filter"].get<std::string>().c_str(),
                r["accepted"].get<int>(), text(r, "precision", "%.3f").c_str(),
                text(r, "recall", "%.3f").c_str(), text(r, "ate_rmse_m", "%.4f").c_str(),
                text(r, "surface_mean_m", "%.4f").c_str(), text(r, "dmp", "%.4f").c_str(),
                text(r, "wall_s", "%.2f").c_str());
    if (r.contains("failure"))
      std::fprintf(stderr, "loopsift-tool: %s gave no result: %s\n", r["filter"].get<std::string>().c_str(),
                   r["failure"].get<std::string>().c_str());
  }
}

Status sweep(const CompareOptions& options, const ContestInput& input, const Truth& truth) {
  const auto rows = run_sweep(input, truth, options.sweep);
  if (!rows) return rows.error();
  if (Status written = write_sweep_csv(options.sweep_csv, *rows); !written) return written;
  std::printf("sweep: %zu runs in %s; tools/scripts/plot_compare.py draws them\n", rows->size(),
              options.sweep_csv.c_str());
  return {};
}

Status check(const CompareOptions& options) {
  if (!options.gt_mesh.empty() && options.truth.trajectory.empty())
    return Error{ErrorCode::kUsage, "--gt-mesh needs --gt, the true trajectory in the mesh's frame"};
  if (options.sweep_csv.empty()) return {};
  if (options.truth.trajectory.empty())
    return Error{ErrorCode::kUsage,
                 "--sweep makes false loops, for which it needs the true trajectory: --gt"};
  return validate(options.sweep);
}

// The sweep adds false loops, as many times as its largest share.
std::size_t room_for_loops(const CompareOptions& options) {
  if (options.sweep_csv.empty()) return 1;
  const auto& shares = options.sweep.false_shares;
  return 2 + static_cast<std::size_t>(*std::max_element(shares.begin(), shares.end()));
}

int compare(CompareOptions options) {
  if (const Status checked = check(options); !checked) return fail(checked.error());
  const auto truth = Truth::read(options.truth);
  if (!truth) return fail(truth.error());
  std::optional<TriangleMesh> mesh;
  if (!options.gt_mesh.empty()) {
    auto read = read_mesh(options.gt_mesh);
    if (!read) return fail(read.error());
    mesh = std::move(*read);
  }
  options.arguments.room_for_loops = room_for_loops(options);
  SiftInput sift;
  int exit_code = kExitDone;
  if (!read_sift_input(options.arguments, &sift, &exit_code)) return exit_code;
  const auto all_true = truth->true_loops(sift.loops, sift.map->fragments());
  if (!all_true) return fail(all_true.error());
  const BackEnd& back_end = sift.map->back_end(0);
  const ContestInput input{sift.map.get(), back_end.calibrated_graph(), 1.0, sift.loops, *all_true};

  const auto rows = table(input, *truth, back_end.scorer(), mesh);
  if (!rows) return fail(rows.error());
  print_table(*rows, input);
  if (const Status written = write_json(options.arguments.json, *rows); !written)
    return fail(written.error());
  if (options.sweep_csv.empty()) return kExitDone;
  const Status swept = sweep(options, input, *truth);
  return swept.ok() ? kExitDone : fail(swept.error());
}

}  // namespace

void add_compare_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "The same loops through published filters and through loopsift: one table");
  add_sift_arguments(command, &options->arguments);
  command->add_option("--gt", options->truth.trajectory, "true trajectory: TUM text or redwood .log");
  command->add_option(
      "--gt-loops", options->truth.loops_log,
      "labelled pairs of fragments, redwood .log, which then say what loops are true instead of "
      "--gt (within 0.10 m and 5 degrees)");
  command->add_option("--gt-info", options->truth.loops_info,
                      "the information matrices of their overlap, redwood .info");
  command->add_option("--gt-mesh", options->gt_mesh, "true surface, OBJ or PLY, in the frame of --gt");
  command->add_option(
      "--sweep", options->sweep_csv,
      "also add false loops and mis-scale the information, and write every filter's figures to "
      "this CSV file");
  command->add_option("--sweep-false", options->sweep.false_shares, "false loops to add, by the true ones")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--sweep-factors", options->sweep.factors, "factors of the information")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--seeds", options->sweep.seeds, "how often each point of the sweep is drawn")
      ->capture_default_str();
  command->callback([options, exit_code] { *exit_code = compare(*options); });
}

}  // namespace loopsift::tool
