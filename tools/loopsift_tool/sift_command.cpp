// SPDX-License-Identifier: MIT
// Algorithm 1 in batch on anyone's trajectory and loops.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>

#include "core/base/steady_time.hpp"
#include "core/pipeline/results.hpp"
#include "core/pipeline/run_report.hpp"
#include "tools/loopsift_tool/anytime_sifting.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/sift_arguments.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {
namespace {

struct SiftOptions {
  SiftArguments arguments;
  ScoreKind score = ScoreKind::kPosterior;
  std::string out;
  double time_limit_s = 0;  // 0: none
};

double seconds_since(std::int64_t begin_ns) { return 1e-9 * static_cast<double>(steady_now_ns() - begin_ns); }

// The batch algorithm, or what a limit leaves of it.
void sift_all(Span<const Loop> loops, double time_limit_s, BackEnd* back_end) {
  const std::int64_t begin_ns = steady_now_ns();
  Ticker ticker("sifting:");
  const auto show = [&](std::size_t done, std::size_t of) { ticker.update(done, of); };
  Sifter& sifter = back_end->sifter();
  if (time_limit_s <= 0) {
    back_end->add_loops(loops);
    sifter.on_progress(show);
    (void)back_end->finish();
    sifter.on_progress({});
    return;
  }
  const auto seconds_left = [&] { return time_limit_s - seconds_since(begin_ns); };
  const bool is_batch = sift_within(seconds_left, loops, back_end, show);
  if (const std::int64_t left = sifter.pending(); left > 0) {
    std::fprintf(stderr, "loopsift-tool: %lld of %zu loops were left undecided by the time limit\n",
                 static_cast<long long>(left), loops.size());
  } else if (!is_batch) {
    std::fputs(
        "loopsift-tool: all loops are decided; the time limit was too short to walk through them once "
        "more from the start, as without a limit\n",
        stderr);
  }
}

void add_sifting_figures(const BackEnd& back_end, RunFigures* figures) {
  const Sifter& sifter = back_end.sifter();
  const SifterCounts& counts = sifter.counts();
  figures->loops.proposed = static_cast<std::int64_t>(sifter.records().size());
  figures->loops.scored = counts.scored;
  figures->loops.tested = counts.tested;
  figures->loops.accepted = static_cast<std::int64_t>(sifter.accepted().size());
  figures->loops.revoked = counts.revoked;
  figures->loops.pending = sifter.pending();
  figures->dmp = {back_end.dmp_odometry(), back_end.dmp_final(), back_end.scorer().view_count()};
  (*figures)[Stage::kLoopSolve] = sifter.solve_times();
  (*figures)[Stage::kLoopScore] = sifter.score_times();
  (*figures)[Stage::kLoopTest] = sifter.test_times();
}

// The graph with a node for every frame: the odometry between frames, every kept loop as loops from the
// first frame of each of its fragments to all frames of the other, and the poses of trajectory.txt.
PoseGraph frame_graph(const OfflineMap& map, const BackEnd& back_end) {
  PoseGraph graph;
  const Fragment* previous = nullptr;
  for (const Fragment& fragment : map.fragments()) {
    append_fragment(previous, fragment, std::numeric_limits<int>::max(), &graph);
    previous = &fragment;
  }
  const Sifter& sifter = back_end.sifter();
  const Trajectory corrected =
      corrected_trajectory(map.frames(), back_end.odometry_graph(), sifter.T_map_node());
  for (std::size_t n = 0; n < graph.T_map_node.size(); ++n)
    graph.T_map_node[n] = corrected.poses[n].T_world_camera;
  for (const Loop& loop : sifter.accepted()) append_frame_loops(graph, loop, &graph.loops);
  return graph;
}

Status write_all(const SiftOptions& options, OfflineMap* map, const RunFigures& figures) {
  const Status results = write_results(options.out, map->back_end(0), map->frames(), map->fragments());
  const Status report = write_run_report(options.out + "/run.json", figures);
  if (!results) return results;
  const Status frames = write_g2o(options.out + "/posegraph_frames.g2o", frame_graph(*map, map->back_end(0)));
  if (!frames) return frames;
  if (!report || options.arguments.json.empty()) return report;
  return write_run_report(options.arguments.json, figures);
}

int sift(SiftOptions options) {
  const std::int64_t begin = steady_now_ns();
  options.arguments.map.back_ends = {options.score};
  if (const Status made = make_folder(options.out); !made) return fail(made.error());
  SiftInput input;
  int exit_code = kExitDone;
  if (!read_sift_input(options.arguments, &input, &exit_code)) return exit_code;
  const double fused_s = seconds_since(begin);
  BackEnd& back_end = input.map->back_end(0);
  const std::int64_t sifting_begin = steady_now_ns();
  sift_all(input.loops, options.time_limit_s, &back_end);
  const double sifted_s = seconds_since(sifting_begin);

  RunFigures figures = input.map->figures();
  add_sifting_figures(back_end, &figures);
  figures.memory.peak_rss_bytes = peak_rss_bytes();
  figures.wall_s = seconds_since(begin);
  if (const Status written = write_all(options, input.map.get(), figures); !written)
    return fail(written.error());
  return show_figures({{"frames with a pose", "frames", figures.frames.tracked, ""},
                       {"fragments", "fragments", back_end.fragment_count(), ""},
                       {"loops", "loops", figures.loops.proposed, ""},
                       {"  accepted", "accepted", figures.loops.accepted, ""},
                       {"  left by the time limit", "pending", figures.loops.pending, ""},
                       {"  revoked in hindsight", "revoked", figures.loops.revoked, ""},
                       {"dense map posterior, odometry", "dmp_odometry", figures.dmp.odometry_m2, "m^2"},
                       {"  after sifting", "dmp_final", figures.dmp.final_m2, "m^2"},
                       {"reading and fusing", "fused_s", fused_s, "s"},
                       {"sifting", "sifted_s", sifted_s, "s"}},
                      "");
}

}  // namespace

void add_sift_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<SiftOptions>();
  CLI::App* command = app.add_subcommand(
      "sift", "Keeps those loops that improve the map, and corrects the trajectory with them");
  add_sift_arguments(command, &options->arguments);
  const std::map<std::string, ScoreKind> scores = {{"posterior", ScoreKind::kPosterior},
                                                   {"plain", ScoreKind::kPlain}};
  command
      ->add_option("--score", options->score,
                   "posterior (default), or plain: the published one, without prior, support or hindsight")
      ->transform(CLI::CheckedTransformer(scores));
  command
      ->add_option(
          "--time-limit", options->time_limit_s,
          "seconds for sifting, after which the best map so far is written; loops that are undecided then "
          "are reported as pending; 0 is no limit")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--out", options->out, "folder for what a run writes; made when missing")->required();
  command->callback([options, exit_code] { *exit_code = sift(*options); });
}

}  // namespace loopsift::tool
