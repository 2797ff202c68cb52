// SPDX-License-Identifier: MIT
// Precision and recall along a ranked list of loops (Zhang & Chen, loop sifting, figure "Precision and recall
// curves of ranking results"). In: the loops.csv and proposals.log of a run, and labels. Out: one point per
// loop, best rank first. Desk code: allocates.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"
#include "tools/evaluation/loop_error.hpp"

namespace loopsift {

/// One row of loops.csv.
struct RankedLoop {
  int id = 0;  ///< place in proposals.log
  int fragment_i = 0, fragment_j = 0;
  int rank = -1;  ///< 0 is the best; −1: not scored
  bool accepted = false;
};

/// Reads loops.csv; columns are found by their names. Errors name file and line or the column.
[[nodiscard]] Expected<std::vector<RankedLoop>> read_ranked_loops(const std::string& path);

/// After looking at so many loops of the list.
struct RankingPoint {
  RankedLoop loop;
  bool correct = false;
  double recall = 0;     ///< labelled pairs found so far / labelled pairs
  double precision = 0;  ///< correct so far / loops so far
};

struct Ranking {
  std::vector<RankingPoint> points;  ///< best first; loops between neighbours and unranked ones are left out
  double average_precision = 0;      ///< Σ precision · Δrecall
};

/// The list as `verdicts` (one per proposal, correct_loops or whoever else knows) judge it; recall is of
/// verdicts.true_loops. Errors: a row whose id or fragments are not those of its proposal; no ranked loop.
[[nodiscard]] Expected<Ranking> rank_loops(const LoopVerdicts& verdicts,
                                           const std::vector<LogRecord>& proposals,
                                           std::vector<RankedLoop> loops);

}  // namespace loopsift
