// SPDX-License-Identifier: MIT
// The same loops through published filters and through ours, in one table.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>

#include "core/base/steady_time.hpp"
#include "core/sifter/map_trial.hpp"
#include "tools/evaluation/trajectory_error.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/filters/filter.hpp"
#include "tools/loopsift_tool/sift_arguments.hpp"

namespace loopsift::tool {
namespace {

constexpr double kTrueWithin_m = 0.10;
constexpr double kTrueWithin_rad = 5.0 * 3.14159265358979 / 180.0;
constexpr double kMaxGap_s = 0.1;  // of ground truth by time, as of odometry

struct CompareOptions {
  SiftArguments arguments;
  std::string gt;
};

/// What a filter left: the loops that it kept, and the poses of all nodes.
struct Outcome {
  std::string filter;
  std::set<int> accepted;
  std::vector<Se3> T_map_node;
  double wall_s = 0;
};

/// The true poses of the frames, where there are any.
class Truth {
 public:
  explicit Truth(Trajectory trajectory) : trajectory_(std::move(trajectory)) {}
  [[nodiscard]] bool pose(const FragmentFrame& frame, Se3* T_gt_camera) const {
    if (trajectory_.indexed) return trajectory_.at(frame.frame.value, 1.0, T_gt_camera);
    return trajectory_.at(1e-9 * static_cast<double>(frame.timestamp_ns), kMaxGap_s, T_gt_camera);
  }

 private:
  Trajectory trajectory_;
};

/// Which loops are true, by id: within 0.10 m and 5° of the true motion between the fragments' first cameras.
Expected<std::set<int>> true_loops(const std::vector<Loop>& loops, Span<const Fragment> fragments,
                                   const Truth& truth) {
  std::set<int> ids;
  for (const Loop& loop : loops) {
    Se3 T_gt_i, T_gt_j;
    for (const auto& [fragment, pose] : {std::pair{loop.i, &T_gt_i}, std::pair{loop.j, &T_gt_j}}) {
      if (!truth.pose(fragments[fragment.index()].frames[0], pose))
        return Error{ErrorCode::kFormat, "--gt: no true pose for the first frame of fragment " +
                                             std::to_string(fragment.value) +
                                             ", which a loop joins; give the whole ground truth"};
    }
    const Se3 error = (T_gt_i.inverse() * T_gt_j).inverse() * loop.T_i_j;
    if (error.translation().norm() <= kTrueWithin_m && error.angle() <= kTrueWithin_rad)
      ids.insert(loop.id.value);
  }
  return ids;
}

/// Corrected against true poses, of the frames that have both.
std::vector<PosePair> pose_pairs(const OfflineMap& map, const PoseGraph& odometry, const Outcome& outcome,
                                 const Truth& truth) {
  const Trajectory corrected = corrected_trajectory(map.frames(), odometry, outcome.T_map_node);
  std::vector<PosePair> pairs;
  std::size_t k = 0;
  for (const Fragment& fragment : map.fragments()) {
    for (const FragmentFrame& frame : fragment.frames) {
      const StampedPose& pose = corrected.poses[k++];
      Se3 T_gt_camera;
      if (truth.pose(frame, &T_gt_camera)) pairs.push_back({pose.time_s, T_gt_camera, pose.T_world_camera});
    }
  }
  return pairs;
}

Expected<std::vector<Outcome>> run_published(const PoseGraph& odometry, const std::vector<Loop>& loops) {
  std::vector<Outcome> outcomes;
  for (const NamedFilter& filter : published_filters()) {
    const std::int64_t begin = steady_now_ns();
    const Expected<FilterResult> result = filter.run(odometry, loops);
    if (!result) return Error{result.error().code, std::string(filter.name) + ": " + result.error().message};
    Outcome outcome{filter.name, {}, result->graph.T_map_node, 1e-9 * double(steady_now_ns() - begin)};
    for (const LoopId id : result->accepted) outcome.accepted.insert(id.value);
    outcomes.push_back(std::move(outcome));
  }
  return outcomes;
}

Outcome run_ours(const char* name, const std::vector<Loop>& loops, BackEnd* back_end) {
  Outcome outcome{name, {}, {}, sift_all(loops, back_end)};
  outcome.T_map_node = back_end->sifter().T_map_node();
  for (const Loop& loop : back_end->sifter().accepted()) outcome.accepted.insert(loop.id.value);
  return outcome;
}

nlohmann::ordered_json fraction(std::size_t part, std::size_t whole) {
  if (whole == 0) return nullptr;  // of nothing
  return static_cast<double>(part) / static_cast<double>(whole);
}

nlohmann::ordered_json row(const Outcome& outcome, const std::set<int>& all_true,
                           const std::vector<PosePair>& pairs, double dmp) {
  std::size_t correct = 0;
  for (const int id : outcome.accepted) correct += all_true.count(id);
  return {{"filter", outcome.filter},
          {"accepted", outcome.accepted.size()},
          {"precision", fraction(correct, outcome.accepted.size())},
          {"recall", fraction(correct, all_true.size())},
          {"ate_rmse_m", trajectory_error(pairs).ate_rmse_m},
          {"dmp", dmp},
          {"wall_s", outcome.wall_s}};
}

void print_table(const nlohmann::ordered_json& rows, std::size_t loops, std::size_t true_count) {
  std::printf("%zu loops, %zu of them true\n", loops, true_count);
  std::printf("%-28s %8s %9s %7s %10s %10s %8s\n", "filter", "accepted", "precision", "recall", "ATE m",
              "DMP m^2", "wall s");
  const auto text = [](const nlohmann::ordered_json& value) {
    char number[16] = "-";
    if (!value.is_null()) std::snprintf(number, sizeof number, "%.3f", value.get<double>());
    return std::string(number);
  };
  for (const auto& r : rows) {
    std::printf("%-28s %8d %9s %7s %10.4f %10.4f %8.2f\n", r["filter"].get<std::string>().c_str(),
                r["accepted"].get<int>(), text(r["precision"]).c_str(), text(r["recall"]).c_str(),
                r["ate_rmse_m"].get<double>(), r["dmp"].get<double>(), r["wall_s"].get<double>());
  }
}

Expected<nlohmann::ordered_json> compare_all(const SiftInput& input, const Truth& truth,
                                             const std::set<int>& all_true) {
  BackEnd& posterior = input.map->back_end(0);
  const PoseGraph& odometry = posterior.calibrated_graph();  // the same weights for every filter
  auto outcomes = run_published(odometry, input.loops);
  if (!outcomes) return outcomes.error();
  outcomes->push_back(run_ours("loopsift", input.loops, &posterior));
  outcomes->push_back(run_ours("loopsift_plain", input.loops, &input.map->back_end(1)));
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Outcome& outcome : *outcomes) {
    const std::vector<PosePair> pairs = pose_pairs(*input.map, odometry, outcome, truth);
    if (pairs.size() < 3)
      return Error{ErrorCode::kFormat, "--gt: fewer than 3 frames of the recording have a true pose"};
    const std::vector<Se3> poses = fragment_poses(odometry, outcome.T_map_node);
    rows.push_back(row(outcome, all_true, pairs, posterior.scorer().score(poses, ScoreKind::kPlain).value));
  }
  return rows;
}

int compare(CompareOptions options) {
  options.arguments.map.back_ends = {ScoreKind::kPosterior, ScoreKind::kPlain};
  auto gt = read_trajectory(options.gt);
  if (!gt) return fail(gt.error());
  const Truth truth(std::move(*gt));
  SiftInput input;
  int exit_code = kExitDone;
  if (!read_sift_input(options.arguments, &input, &exit_code)) return exit_code;
  const auto all_true = true_loops(input.loops, input.map->fragments(), truth);
  if (!all_true) return fail(all_true.error());
  const auto rows = compare_all(input, truth, *all_true);
  if (!rows) return fail(rows.error());
  print_table(*rows, input.loops.size(), all_true->size());
  const Status written = write_json(options.arguments.json, *rows);
  return written.ok() ? kExitDone : fail(written.error());
}

}  // namespace

void add_compare_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "The same loops through published filters and through loopsift: one table");
  add_sift_arguments(command, &options->arguments);
  command->add_option("--gt", options->gt, "true trajectory: TUM text or redwood .log")->required();
  command->callback([options, exit_code] { *exit_code = compare(*options); });
}

}  // namespace loopsift::tool
