// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/run_evaluation.hpp"

#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "tools/evaluation/loop_ranking.hpp"
#include "tools/evaluation/point_ply.hpp"
#include "tools/evaluation/trajectory_error.hpp"
#include "tools/evaluation/trajectory_formats.hpp"
#include "tools/loopsift_tool/evaluation_json.hpp"

namespace loopsift::tool {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTrueWithin_m = 0.10, kTrueWithin_deg = 5.0;
constexpr double kMaxGap_s = 0.1;
constexpr double kDegreesPerRadian = 57.29577951308232;

bool exists(const std::string& path) { return std::filesystem::exists(path); }

/// A truth by frame number gets the times of the run's frames.
Expected<Trajectory> timed_truth(const std::string& path, const Trajectory& odometry) {
  auto gt = read_any_trajectory(path);
  if (!gt.ok() || !gt->indexed) return gt;
  if (gt->poses.size() != odometry.poses.size())
    return Error{ErrorCode::kUsage, path + " is by frame number and has " + std::to_string(gt->poses.size()) +
                                        " poses, the run has " + std::to_string(odometry.poses.size()) +
                                        "; give a truth with times"};
  for (std::size_t k = 0; k < gt->poses.size(); ++k) gt->poses[k].time_s = odometry.poses[k].time_s;
  gt->indexed = false;
  return gt;
}

Json position_json(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

/// Errors of one trajectory; positions go into the map's frame by T_map_gt.
Json truth_json(const std::vector<PosePair>& pairs, const Se3& T_map_gt) {
  Json json = trajectory_error_json(trajectory_error(pairs));
  const Se3 T_gt_est = align(pairs);
  for (const char* key : {"time_s", "error_m", "truth", "estimate"}) json[key] = Json::array();
  for (const PosePair& p : pairs) {
    const Eigen::Vector3d estimate = T_gt_est * p.T_est_camera.translation();
    json["time_s"].push_back(p.time_s);
    json["error_m"].push_back((estimate - p.T_gt_camera.translation()).norm());
    json["truth"].push_back(position_json(T_map_gt * p.T_gt_camera.translation()));
    json["estimate"].push_back(position_json(T_map_gt * estimate));
  }
  return json;
}

class RunEvaluator {
 public:
  explicit RunEvaluator(const RunEvaluationOptions& options) : options_(options) {
    json_["notes"] = Json::array();
  }

  Expected<RunEvaluation> run() {
    for (const auto step : {&RunEvaluator::read_trajectories, &RunEvaluator::read_fragments,
                            &RunEvaluator::trajectories, &RunEvaluator::loops, &RunEvaluator::residual})
      if (Status s = (this->*step)(); !s) return s.error();
    return RunEvaluation{std::move(json_), std::move(residual_)};
  }

 private:
  [[nodiscard]] std::string file(const char* name) const { return options_.folder + "/" + name; }
  void note(const std::string& text) { json_["notes"].push_back(text); }

  /// A run's file that is broken is the page's to tell; here it is as if it were not there.
  Status read_trajectories() {
    if (auto read = read_any_trajectory(file("trajectory_odometry.txt")); read.ok()) odometry_ = *read;
    if (auto read = read_any_trajectory(file("trajectory.txt")); read.ok()) corrected_ = *read;
    if (options_.gt.empty()) return {};
    if (odometry_.poses.empty()) {
      note("Without trajectory_odometry.txt nothing can be held against the ground truth.");
      return {};
    }
    auto gt = timed_truth(options_.gt, odometry_);
    if (!gt.ok()) return gt.error();
    gt_ = std::move(*gt);
    return {};
  }

  Status read_fragments() {
    if (const auto fragments = read_ply_fragments(file("map.ply")); fragments.ok())
      for (const PlyFragment& fragment : *fragments) fragment_times_.push_back(fragment.first_frame_s);
    return {};
  }

  Status trajectories() {
    if (gt_.poses.empty()) return {};
    const auto odometry = associate(gt_, odometry_, {});
    if (!odometry.ok()) return odometry.error();
    Se3 T_map_gt = align(*odometry).inverse();
    std::optional<std::vector<PosePair>> corrected;
    if (!corrected_.poses.empty()) {
      const auto pairs = associate(gt_, corrected_, {});
      if (!pairs.ok()) return pairs.error();
      corrected = *pairs;
      T_map_gt = align(*corrected).inverse();
    }
    json_["truth"]["odometry"] = truth_json(*odometry, T_map_gt);
    if (corrected) json_["truth"]["corrected"] = truth_json(*corrected, T_map_gt);
    return {};
  }

  /// T_i_j by the true trajectory; nothing where it does not reach.
  [[nodiscard]] std::optional<Se3> true_motion(int i, int j) const {
    const auto pose = [this](int fragment, Se3* T) {
      const auto k = static_cast<std::size_t>(fragment);
      return fragment >= 0 && k < fragment_times_.size() && gt_.at(fragment_times_[k], kMaxGap_s, T);
    };
    Se3 T_gt_i, T_gt_j;
    if (gt_.poses.empty() || !pose(i, &T_gt_i) || !pose(j, &T_gt_j)) return {};
    return T_gt_i.inverse() * T_gt_j;
  }

  /// Judged by the true trajectory; recall is of the pairs that a true proposal joins.
  LoopVerdicts verdicts_by_trajectory(const std::vector<LogRecord>& proposals) {
    LoopVerdicts verdicts;
    std::set<std::pair<int, int>> pairs;
    for (std::size_t k = 0; k < proposals.size(); ++k) {
      const auto T_i_j = true_motion(proposals[k].a, proposals[k].b);
      bool correct = false;
      if (T_i_j) {
        const Se3 off = T_i_j->inverse() * proposals[k].T;
        const double m = off.translation().norm(), deg = off.angle() * kDegreesPerRadian;
        correct = m <= kTrueWithin_m && deg <= kTrueWithin_deg;
        verdicts_json_.push_back({{"id", k}, {"error_m", m}, {"error_deg", deg}, {"correct", correct}});
      }
      if (correct) pairs.insert(std::minmax(proposals[k].a, proposals[k].b));
      verdicts.counts.push_back(T_i_j.has_value());
      verdicts.correct.push_back(correct);
    }
    verdicts.true_loops = static_cast<int>(pairs.size());
    return verdicts;
  }

  Expected<LoopVerdicts> verdicts_by_labels(const std::vector<LogRecord>& proposals) {
    const auto gt = read_log(options_.gt_loops);
    if (!gt.ok()) return gt.error();
    const auto info = read_info(options_.gt_info);
    if (!info.ok()) return info.error();
    auto verdicts = correct_loops(*gt, *info, proposals, options_.labels);
    if (!verdicts.ok()) return verdicts;
    if (verdicts_json_.empty())
      for (std::size_t k = 0; k < proposals.size(); ++k)
        verdicts_json_.push_back({{"id", k}, {"correct", static_cast<bool>(verdicts->correct[k])}});
    return verdicts;
  }

  Status loops() {
    const bool labelled = !options_.gt_loops.empty();
    if (!labelled && gt_.poses.empty()) return {};
    const auto proposals = read_log(file("proposals.log"));
    const auto ranked = read_ranked_loops(file("loops.csv"));
    if (!proposals.ok() || !ranked.ok()) {
      note("Without proposals.log and loops.csv no loop can be held against the truth.");
      return {};
    }
    if (!labelled && fragment_times_.empty()) {
      note(
          "map.ply does not say when its fragments begin, so no loop can be held against the true "
          "trajectory.");
      return {};
    }
    LoopVerdicts verdicts = verdicts_by_trajectory(*proposals);
    std::string about =
        "True: within 0.10 m and 5° of the true trajectory; recall is of the true loops proposed.";
    if (labelled) {
      const auto by_labels = verdicts_by_labels(*proposals);
      if (!by_labels.ok()) return by_labels.error();
      verdicts = *by_labels;
      about = "True: labelled, and within 0.2 m (RMS) over the overlap; recall is of the " +
              std::to_string(verdicts.true_loops) + " labelled pairs; a pair without label counts as false.";
    }
    json_["loops"] = verdicts_json_;
    const bool ranks =
        std::any_of(ranked->begin(), ranked->end(), [](const RankedLoop& l) { return l.rank >= 0; });
    if (!ranks || verdicts.true_loops == 0) {
      note("No true loop was proposed and ranked, so there is no precision-recall curve.");
      return {};
    }
    const auto ranking = rank_loops(verdicts, *proposals, *ranked);
    if (!ranking.ok()) return ranking.error();
    json_["ranking"] = {{"about", about},
                        {"average_precision", ranking->average_precision},
                        {"curve", ranking_json(*ranking)}};
    return {};
  }

  Status residual() {
    if (options_.source.empty()) return {};
    if (odometry_.poses.empty() || corrected_.poses.empty() || fragment_times_.empty()) {
      note("Without map.ply and both trajectories the map cannot be held against the recording.");
      return {};
    }
    auto residual = measure_map_residual(
        {file("map.ply"), file("trajectory_odometry.txt"), &odometry_, &corrected_, options_.source});
    if (!residual.ok()) return residual.error();
    residual_ = std::move(*residual);
    Json& json = json_["dmp_views"];
    for (const char* key : {"frame", "time_s", "before", "after"}) json[key] = Json::array();
    for (const MapResidual::View& view : residual_.views) {
      json["frame"].push_back(view.frame);
      json["time_s"].push_back(view.time_s);
      json["before"].push_back(view.before_m2);
      json["after"].push_back(view.after_m2);
    }
    return {};
  }

  RunEvaluationOptions options_;
  Json json_ = Json::object(), verdicts_json_ = Json::array();
  MapResidual residual_;
  Trajectory odometry_, corrected_, gt_;
  std::vector<double> fragment_times_;
};

}  // namespace

Expected<RunEvaluation> evaluate_run(const RunEvaluationOptions& options) {
  if (!exists(options.folder))
    return Error{ErrorCode::kNotFound,
                 options.folder + ": is not there; give the folder that --out of a run named"};
  if (options.gt_loops.empty() != options.gt_info.empty())
    return Error{ErrorCode::kUsage, "--gt-loops and --gt-info belong together; give both"};
  return RunEvaluator(options).run();
}

}  // namespace loopsift::tool
