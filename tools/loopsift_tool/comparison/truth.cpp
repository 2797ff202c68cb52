// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/comparison/truth.hpp"

#include "tools/evaluation/loop_error.hpp"

namespace loopsift::tool {
namespace {
constexpr double kMaxGap_s = 0.1;  // of ground truth by time, as of odometry
}

Expected<Truth> Truth::read(const TruthFiles& files) {
  if (files.trajectory.empty() && files.loops_log.empty())
    return Error{ErrorCode::kUsage, "nothing is known to be true: give --gt, or --gt-loops with --gt-info"};
  Truth truth;
  if (!files.trajectory.empty()) {
    Expected<Trajectory> trajectory = read_trajectory(files.trajectory);
    if (!trajectory) return trajectory.error();
    truth.trajectory_ = std::move(*trajectory);
  }
  if (!files.loops_log.empty() || !files.loops_info.empty())
    if (const Status labels = truth.read_labels(files); !labels) return labels.error();
  return truth;
}

Status Truth::read_labels(const TruthFiles& files) {
  if (files.loops_log.empty() || files.loops_info.empty())
    return Error{ErrorCode::kUsage,
                 "--gt-loops and --gt-info go together: the labelled pairs and the "
                 "information matrices of their overlap"};
  const Expected<std::vector<LogRecord>> pairs = read_log(files.loops_log);
  if (!pairs) return pairs.error();
  const Expected<std::vector<InfoRecord>> infos = read_info(files.loops_info);
  if (!infos) return infos.error();
  if (pairs->size() != infos->size())
    return Error{ErrorCode::kFormat, files.loops_info + ": has " + std::to_string(infos->size()) +
                                         " records, " + files.loops_log + " has " +
                                         std::to_string(pairs->size()) +
                                         "; give the .info of the same pairs"};
  labels_.emplace();
  for (std::size_t k = 0; k < pairs->size(); ++k) {
    const LogRecord& pair = (*pairs)[k];
    if ((*infos)[k].a != pair.a || (*infos)[k].b != pair.b)
      return Error{ErrorCode::kFormat, files.loops_info + ": record " + std::to_string(k + 1) +
                                           " is of another pair than in " + files.loops_log};
    (*labels_)[{pair.a, pair.b}] = {pair.T, (*infos)[k].information};
  }
  return {};
}

bool Truth::pose(const FragmentFrame& frame, Se3* T_gt_camera) const {
  if (!trajectory_) return false;
  if (trajectory_->indexed) return trajectory_->at(frame.frame.value, 1.0, T_gt_camera);
  return trajectory_->at(1e-9 * static_cast<double>(frame.timestamp_ns), kMaxGap_s, T_gt_camera);
}

Expected<Se3> Truth::motion(Span<const Fragment> fragments, FragmentId i, FragmentId j) const {
  Se3 T_gt_i, T_gt_j;
  for (const auto& [fragment, T] : {std::pair{i, &T_gt_i}, std::pair{j, &T_gt_j}}) {
    if (!pose(fragments[fragment.index()].frames[0], T))
      return Error{ErrorCode::kFormat, "--gt: no true pose for the first frame of fragment " +
                                           std::to_string(fragment.value) +
                                           ", which a loop joins; give the whole ground truth"};
  }
  return T_gt_i.inverse() * T_gt_j;
}

bool Truth::is_labelled(const Loop& loop) const {
  constexpr double kMaxError_m2 = 0.04;
  const auto label = labels_->find({loop.i.value, loop.j.value});
  return label != labels_->end() &&
         loop_error_m2(label->second.T_i_j, label->second.information, loop.T_i_j) <= kMaxError_m2;
}

Expected<std::set<int>> Truth::true_loops(const std::vector<Loop>& loops,
                                          Span<const Fragment> fragments) const {
  std::set<int> ids;
  for (const Loop& loop : loops) {
    if (labels_) {
      if (is_labelled(loop)) ids.insert(loop.id.value);
      continue;
    }
    const Expected<Se3> T_i_j = motion(fragments, loop.i, loop.j);
    if (!T_i_j) return T_i_j.error();
    const Se3 error = T_i_j->inverse() * loop.T_i_j;
    if (error.translation().norm() <= kTrueWithin_m && error.angle() <= kTrueWithin_rad)
      ids.insert(loop.id.value);
  }
  return ids;
}

}  // namespace loopsift::tool
