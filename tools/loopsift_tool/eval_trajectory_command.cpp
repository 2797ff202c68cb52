// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "tools/evaluation/trajectory_error.hpp"
#include "tools/evaluation/trajectory_formats.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

struct EvalTrajectoryOptions {
  std::string gt, est, gt_format, est_format, json;
  AssociationOptions association;
};

/// An empty format is found out.
Expected<Trajectory> read(const std::string& path, const std::string& format) {
  if (format.empty()) return read_any_trajectory(path);
  const auto named = trajectory_format(format);
  if (!named.ok()) return named.error();
  return read_any_trajectory(path, *named);
}

nlohmann::ordered_json value_or_null(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

int eval_trajectory(const EvalTrajectoryOptions& options) {
  const auto gt = read(options.gt, options.gt_format);
  if (!gt.ok()) return fail(gt.error());
  const auto est = read(options.est, options.est_format);
  if (!est.ok()) return fail(est.error());
  const auto pairs = associate(*gt, *est, options.association);
  if (!pairs.ok()) return fail(pairs.error());
  const TrajectoryError error = trajectory_error(*pairs);
  return show_figures(
      {{"absolute error after alignment, RMSE", "ate_rmse_m", error.ate_rmse_m, "m"},
       {"  mean", "ate_mean_m", error.ate_mean_m, "m"},
       {"  largest", "ate_max_m", error.ate_max_m, "m"},
       {"relative error over 1 s, RMSE", "rpe_trans_rmse_m", value_or_null(error.rpe_trans_rmse_m), "m"},
       {"  rotation", "rpe_rot_rmse_deg", value_or_null(error.rpe_rot_rmse_deg), "deg"},
       {"pose pairs", "pairs", error.pairs, ""}},
      options.json);
}

}  // namespace

void add_eval_trajectory_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<EvalTrajectoryOptions>();
  CLI::App* command = app.add_subcommand("eval-trajectory",
                                         "Absolute and relative error of a trajectory against ground truth");
  command
      ->add_option("--gt", options->gt, "true trajectory: TUM, KITTI, redwood .log, or EuRoC's csv or folder")
      ->required();
  command->add_option("--est", options->est, "estimated trajectory: the same formats")->required();
  command->add_option("--gt-format", options->gt_format,
                      "tum, kitti, euroc or redwood; by default told by the content");
  command->add_option("--format", options->est_format, "the same of --est");
  command->add_flag("--by-index", options->association.by_index,
                    "pair the k-th pose with the k-th instead of by time");
  command
      ->add_option("--max-difference-s", options->association.max_difference_s,
                   "time stamps at most this far apart belong to one frame")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--rate-hz", options->association.rate_hz,
                   "frame rate of redwood and KITTI files, for the second of the relative error")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = eval_trajectory(*options); });
}

}  // namespace loopsift::tool
