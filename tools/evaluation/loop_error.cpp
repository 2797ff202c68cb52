// SPDX-License-Identifier: MIT
#include "tools/evaluation/loop_error.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace loopsift {
namespace {

using Pair = std::pair<int, int>;

struct Label {
  Se3 T_i_j;
  Matrix6d information;
};

Error usage(std::string message) { return {ErrorCode::kUsage, std::move(message)}; }

std::string name(int a, int b) { return std::to_string(a) + " " + std::to_string(b); }

bool is_loop(int i, int j) { return j - i > 1; }

/// The record with its smaller fragment first.
LogRecord ordered(const LogRecord& record) {
  return record.a <= record.b ? record : LogRecord{record.b, record.a, record.n, record.T.inverse()};
}

Expected<std::map<Pair, Label>> labelled_pairs(const std::vector<LogRecord>& gt,
                                               const std::vector<InfoRecord>& gt_info, int fragments) {
  if (gt.size() != gt_info.size())
    return usage("the ground truth has " + std::to_string(gt.size()) + " transforms and " +
                 std::to_string(gt_info.size()) +
                 " information matrices; the two files do not belong together");
  std::map<Pair, Label> labels;
  for (std::size_t k = 0; k < gt.size(); ++k) {
    if (gt[k].a != gt_info[k].a || gt[k].b != gt_info[k].b)
      return usage("record " + std::to_string(k) + " of the ground truth is pair " + name(gt[k].a, gt[k].b) +
                   " but its information matrix is of " + name(gt_info[k].a, gt_info[k].b) +
                   "; the two files do not belong together");
    if (is_loop(gt[k].a, gt[k].b) && gt[k].b < fragments)
      labels[{gt[k].a, gt[k].b}] = {gt[k].T, gt_info[k].information};
  }
  if (labels.empty()) return usage("the ground truth labels no loop (no pair i j with j - i > 1)");
  return labels;
}

Status check_loops(const std::vector<LogRecord>& loops, int fragments, bool same_count) {
  for (const LogRecord& loop : loops) {
    if (same_count && loop.n != fragments)
      return usage("the loops are of " + std::to_string(loop.n) + " fragments but the ground truth is of " +
                   std::to_string(fragments) + "; give --fragments to look at the first so many of both");
    if (loop.a < 0 || loop.b < 0 || (same_count && (loop.a >= fragments || loop.b >= fragments)))
      return usage("loop " + name(loop.a, loop.b) + " names a fragment that does not exist; there are " +
                   std::to_string(fragments));
  }
  return {};
}

}  // namespace

double loop_error_m2(const Se3& T_gt, const Matrix6d& information, const Se3& T) {
  const Se3 difference = T_gt.inverse() * T;
  Eigen::Quaterniond q = difference.quaternion();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  Vector6d xi;
  xi << difference.translation(), 2.0 * q.vec();
  return xi.dot(information * xi) / information(0, 0);
}

Expected<LoopVerdicts> correct_loops(const std::vector<LogRecord>& gt, const std::vector<InfoRecord>& gt_info,
                                     const std::vector<LogRecord>& loops,
                                     const LoopEvaluationOptions& options) {
  const bool same_count = options.fragments <= 0;
  const int labelled_fragments = gt.empty() ? 0 : gt.front().n;
  const int fragments = same_count ? labelled_fragments : options.fragments;
  const auto labels = labelled_pairs(gt, gt_info, fragments);
  if (!labels.ok()) return labels.error();
  if (const Status checked = check_loops(loops, fragments, same_count); !checked.ok()) return checked.error();

  LoopVerdicts verdicts;
  verdicts.true_loops = static_cast<int>(labels->size());
  for (const LogRecord& record : loops) {
    const LogRecord loop = ordered(record);
    const bool counts = is_loop(loop.a, loop.b) && loop.b < fragments;
    const auto label = labels->find({loop.a, loop.b});
    verdicts.counts.push_back(counts);
    verdicts.correct.push_back(counts && label != labels->end() &&
                               loop_error_m2(label->second.T_i_j, label->second.information, loop.T) <=
                                   options.max_error_m2);
  }
  return verdicts;
}

Expected<LoopError> evaluate_loops(const std::vector<LogRecord>& gt, const std::vector<InfoRecord>& gt_info,
                                   const std::vector<LogRecord>& loops,
                                   const LoopEvaluationOptions& options) {
  const auto verdicts = correct_loops(gt, gt_info, loops, options);
  if (!verdicts.ok()) return verdicts.error();
  LoopError error;
  error.true_loops = verdicts->true_loops;
  std::set<Pair> found;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    error.loops += verdicts->counts[k] ? 1 : 0;
    if (!verdicts->correct[k]) continue;
    ++error.correct;
    found.insert(std::minmax(loops[k].a, loops[k].b));
  }
  error.recall = static_cast<double>(found.size()) / error.true_loops;
  if (error.loops > 0) error.precision = static_cast<double>(error.correct) / error.loops;
  return error;
}

}  // namespace loopsift
