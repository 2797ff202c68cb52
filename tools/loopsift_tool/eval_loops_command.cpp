// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "tools/evaluation/loop_error.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

struct EvalLoopsOptions {
  std::string gt, gt_info, loops, json;
  LoopEvaluationOptions evaluation;
};

int eval_loops(const EvalLoopsOptions& options) {
  const auto gt = read_log(options.gt);
  if (!gt.ok()) return fail(gt.error());
  const auto gt_info = read_info(options.gt_info);
  if (!gt_info.ok()) return fail(gt_info.error());
  const auto loops = read_log(options.loops);
  if (!loops.ok()) return fail(loops.error());
  const auto error = evaluate_loops(*gt, *gt_info, *loops, options.evaluation);
  if (!error.ok()) return fail(error.error());
  return show_figures({{"recall", "recall", error->recall, ""},
                       {"precision", "precision", error->precision, ""},
                       {"true loops", "true_loops", error->true_loops, ""},
                       {"loops", "loops", error->loops, ""},
                       {"  correct", "correct", error->correct, ""}},
                      options.json);
}

}  // namespace

void add_eval_loops_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<EvalLoopsOptions>();
  CLI::App* command = app.add_subcommand(
      "eval-loops", "Recall and precision of loops between fragments against labelled pairs");
  command->add_option("--gt", options->gt, "true transforms, redwood .log")->required();
  command->add_option("--gt-info", options->gt_info, "their information matrices, redwood .info")->required();
  command->add_option("--loops", options->loops, "the loops, redwood .log")->required();
  command
      ->add_option(
          "--fragments", options->evaluation.fragments,
          "look only at pairs of the first so many fragments, where the labels are of a longer recording")
      ->check(CLI::PositiveNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = eval_loops(*options); });
}

}  // namespace loopsift::tool
