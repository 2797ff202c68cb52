// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "tools/evaluation/trajectory_error.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

struct EvalTrajectoryOptions {
  std::string gt, est, json;
  AssociationOptions association;
};

nlohmann::ordered_json value_or_null(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

int eval_trajectory(const EvalTrajectoryOptions& options) {
  const auto gt = read_trajectory(options.gt);
  if (!gt.ok()) return fail(gt.error());
  const auto est = read_trajectory(options.est);
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
  command->add_option("--gt", options->gt, "true trajectory: TUM text or redwood .log")->required();
  command->add_option("--est", options->est, "estimated trajectory: TUM text or redwood .log")->required();
  command->add_flag("--by-index", options->association.by_index,
                    "pair the k-th pose with the k-th instead of by time (within 20 ms)");
  command
      ->add_option("--rate-hz", options->association.rate_hz,
                   "frame rate of .log files, for the second of the relative error")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = eval_trajectory(*options); });
}

}  // namespace loopsift::tool
