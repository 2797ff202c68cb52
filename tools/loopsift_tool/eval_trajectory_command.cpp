// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <cstdio>
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

void print_row(const char* name, const std::optional<double>& value, const char* unit) {
  if (value) {
    std::printf("%-38s %10.4f %s\n", name, *value, unit);
  } else {
    std::printf("%-38s %10s\n", name, "-");
  }
}

int eval_trajectory(const EvalTrajectoryOptions& options) {
  const auto gt = read_trajectory(options.gt);
  if (!gt.ok()) return fail(gt.error());
  const auto est = read_trajectory(options.est);
  if (!est.ok()) return fail(est.error());
  const auto pairs = associate(*gt, *est, options.association);
  if (!pairs.ok()) return fail(pairs.error());
  const TrajectoryError error = trajectory_error(*pairs);

  std::printf("%-38s %10d\n", "pairs", error.pairs);
  print_row("absolute error after alignment, RMSE", error.ate_rmse_m, "m");
  print_row("  mean", error.ate_mean_m, "m");
  print_row("  largest", error.ate_max_m, "m");
  print_row("relative error over 1 s, RMSE", error.rpe_trans_rmse_m, "m");
  print_row("  rotation", error.rpe_rot_rmse_deg, "deg");

  nlohmann::ordered_json json{{"ate_rmse_m", error.ate_rmse_m}, {"ate_mean_m", error.ate_mean_m},
                              {"ate_max_m", error.ate_max_m},   {"rpe_trans_rmse_m", nullptr},
                              {"rpe_rot_rmse_deg", nullptr},    {"pairs", error.pairs}};
  if (error.rpe_trans_rmse_m) json["rpe_trans_rmse_m"] = *error.rpe_trans_rmse_m;
  if (error.rpe_rot_rmse_deg) json["rpe_rot_rmse_deg"] = *error.rpe_rot_rmse_deg;
  if (const Status written = write_json(options.json, json); !written.ok()) return fail(written.error());
  return kExitDone;
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
