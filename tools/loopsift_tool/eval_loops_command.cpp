// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "tools/evaluation/loop_ranking.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/evaluation_json.hpp"

namespace loopsift::tool {
namespace {

struct EvalLoopsOptions {
  std::string gt, gt_info, loops, ranking, json;
  LoopEvaluationOptions evaluation;
};

/// Every accepted loop, every false one, and the last of the list.
void print_curve(const Ranking& ranking) {
  std::printf("\n%6s  %11s  %-8s %-9s %8s %10s\n", "rank", "fragments", "", "", "recall", "precision");
  for (const RankingPoint& p : ranking.points) {
    if (!p.loop.accepted && p.correct && &p != &ranking.points.back()) continue;
    std::printf("%6d  %5d %5d  %-8s %-9s %8.4f %10.4f\n", p.loop.rank, p.loop.fragment_i, p.loop.fragment_j,
                p.correct ? "true" : "false", p.loop.accepted ? "accepted" : "", p.recall, p.precision);
  }
}

struct Judged {
  LoopError error;
  std::optional<Ranking> ranking;
};

Expected<Judged> judge(const EvalLoopsOptions& options) {
  const auto gt = read_log(options.gt);
  if (!gt.ok()) return gt.error();
  const auto gt_info = read_info(options.gt_info);
  if (!gt_info.ok()) return gt_info.error();
  const auto loops = read_log(options.loops);
  if (!loops.ok()) return loops.error();
  const auto error = evaluate_loops(*gt, *gt_info, *loops, options.evaluation);
  if (!error.ok()) return error.error();
  Judged judged{*error, {}};
  if (options.ranking.empty()) return judged;
  const auto ranked = read_ranked_loops(options.ranking);
  if (!ranked.ok()) return ranked.error();
  const auto verdicts = correct_loops(*gt, *gt_info, *loops, options.evaluation);
  if (!verdicts.ok()) return verdicts.error();
  auto ranking = rank_loops(*verdicts, *loops, *ranked);
  if (!ranking.ok()) return ranking.error();
  judged.ranking = std::move(*ranking);
  return judged;
}

int eval_loops(const EvalLoopsOptions& options) {
  const auto judged = judge(options);
  if (!judged.ok()) return fail(judged.error());
  const LoopError& error = judged->error;
  std::vector<Figure> figures = {{"recall", "recall", error.recall, ""},
                                 {"precision", "precision", error.precision, ""},
                                 {"true loops", "true_loops", error.true_loops, ""},
                                 {"loops", "loops", error.loops, ""},
                                 {"  correct", "correct", error.correct, ""}};
  if (!judged->ranking) return show_figures(figures, options.json);
  figures.push_back(
      {"average precision of the ranking", "average_precision", judged->ranking->average_precision, ""});
  if (const int exit_code = show_figures(figures, ""); exit_code != kExitDone) return exit_code;
  print_curve(*judged->ranking);
  nlohmann::ordered_json json;
  for (const Figure& figure : figures) json[figure.key] = figure.value;
  json["curve"] = ranking_json(*judged->ranking);
  const Status written = write_json(options.json, json);
  return written.ok() ? kExitDone : fail(written.error());
}

}  // namespace

void add_eval_loops_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<EvalLoopsOptions>();
  CLI::App* command = app.add_subcommand(
      "eval-loops", "Recall and precision of loops between fragments against labelled pairs");
  command->add_option("--gt", options->gt, "true transforms, redwood .log")->required();
  command->add_option("--gt-info", options->gt_info, "their information matrices, redwood .info")->required();
  command->add_option("--loops", options->loops, "the loops, redwood .log")->required();
  command->add_option(
      "--ranking", options->ranking,
      "the loops.csv of the run whose proposals.log is --loops: precision and recall along its "
      "ranking, too");
  command
      ->add_option(
          "--fragments", options->evaluation.fragments,
          "look only at pairs of the first so many fragments, where the labels are of a longer recording")
      ->check(CLI::PositiveNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = eval_loops(*options); });
}

}  // namespace loopsift::tool
