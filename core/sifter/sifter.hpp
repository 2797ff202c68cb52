// SPDX-License-Identifier: MIT
// Algorithm 1 of Zhang & Chen, "Self-optimizing loop sifting and majorization for 3D reconstruction": which
// of the proposed loops the map is better with. No threshold anywhere.
//
// In: the odometry's pose graph, the scored fragments, loops. Out: a decision with its numbers for every
// loop, and the poses of the best map. Used in batch (all loops at once) and incrementally (as fragments
// close), by the same three steps:
//   add()    scores each new loop alone on the odometry's map                              (lines 2–6)
//   walk()   goes through loops best first, keeps those that improve the map               (lines 7–14)
//   review() takes back accepted loops without which the map is better (hindsight)
// Thread: back. Allocates. Deterministic.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/latency_histogram.hpp"
#include "core/base/span.hpp"
#include "core/proposal/loop.hpp"
#include "core/sifter/map_trial.hpp"

namespace loopsift {

struct SifterOptions {
  ScoreKind score = ScoreKind::kPosterior;
  bool hindsight = true;  ///< test accepted loops again by removal; not part of the paper, off for its tables
  bool challenge =
      true;  ///< a loop must explain its two fragments better than its neighbours do (see challenge())
  SolveOptions solve;
};

enum class Decision { kPending, kAccepted, kRejected, kRevoked };

/// Why a loop was decided as it was; the text of `reason` in loops.csv.
enum class Reason {
  kNotTested,
  kImproves,       ///< the map is better with it
  kNoImprovement,  ///< the map is not better with it
  kInsignificant,  ///< it is, but by no more than its standard error over the views
  kChallenged,     ///< a motion next to it explains the two fragments better
  kSolveFailed,    ///< the pose graph could not be optimised with it
  kBetterWithout,  ///< accepted once; the map is better without it since others came in
};
[[nodiscard]] const char* to_string(Decision decision);
[[nodiscard]] const char* to_string(Reason reason);

/// A loop with its numbers. Scores in m², lower is better, of the chosen ScoreKind.
struct SiftedLoop {
  Loop loop;
  double single_score = 0;  ///< of the odometry's map with this loop alone
  double improvement =
      0;          ///< score of the odometry's map − single_score, when it was measured; the rank's key
  int rank = -1;  ///< place in the list of the last walk, 0 is best
  double tested_score = 0;  ///< with the loops accepted before it; a lower bound where the test gave up early
  double best_score_before = 0;
  Decision decision = Decision::kPending;
  Reason reason = Reason::kNotTested;
  int frame_decided = -1;                    ///< newest frame in the map when it was decided
  std::vector<std::uint16_t> telling_views;  ///< views that it alone made worse, worst first
};

struct SifterCounts {
  std::int64_t scored = 0, tested = 0, revoked = 0;
};

class Sifter {
 public:
  /// scorer must outlive this and hold a fragment for each of the graph's whenever one of the steps below
  /// runs.
  Sifter(const SifterOptions& options, MapScorer& scorer);

  /// The odometry's graph, after each new fragment. Accepted loops and the poses of older fragments stay; new
  /// nodes follow the last one. newest_frame goes into the records.
  void set_graph(const PoseGraph& odometry, int newest_frame);
  /// Step 1: scores each loop alone. Loops that name a fragment not in the graph are decided kSolveFailed.
  void add(Span<const Loop> loops);
  /// Steps 2 and 3. pending_only: walks the loops not decided yet, on top of the accepted ones; else starts
  /// again from the odometry's map with all loops. Returns how many more loops are accepted.
  int walk(bool pending_only);
  /// Tests accepted loops by removal, the worst ranked first, until none is better left out. Returns how many
  /// were revoked.
  int review();

  [[nodiscard]] const std::vector<SiftedLoop>& records() const { return records_; }
  [[nodiscard]] std::vector<Loop> accepted() const;
  /// Poses of the best map, by node.
  [[nodiscard]] const std::vector<Se3>& T_map_node() const { return best_.T_map_node; }
  /// The odometry's graph with the best map's poses and the frame loops of the accepted loops.
  [[nodiscard]] PoseGraph graph() const;
  /// Newest frame in the map, as given to set_graph.
  [[nodiscard]] int newest_frame() const { return newest_frame_; }
  [[nodiscard]] double base_score() const { return base_.score; }
  [[nodiscard]] double best_score() const { return best_.score; }
  [[nodiscard]] const SifterCounts& counts() const { return counts_; }
  /// Times of solves, scores and whole tests.
  [[nodiscard]] const LatencyHistogram& solve_times() const { return solve_times_; }
  [[nodiscard]] const LatencyHistogram& score_times() const { return score_times_; }
  [[nodiscard]] const LatencyHistogram& test_times() const { return test_times_; }
  /// Called after each loop that add, walk or review dealt with: how many are done, of how many. May be
  /// empty.
  void on_progress(std::function<void(std::size_t, std::size_t)> callback) {
    progress_ = std::move(callback);
  }

 private:
  void solve_accepted(const std::vector<Se3>& start);
  void score_alone(SiftedLoop* record);
  [[nodiscard]] std::vector<std::size_t> ranked(bool pending_only);
  [[nodiscard]] bool test(SiftedLoop* record);
  [[nodiscard]] bool test_removal(std::size_t accepted_index);
  void append_edges(const Loop& loop, std::vector<Edge>* edges) const;
  [[nodiscard]] std::vector<Edge> frame_loops_of(const std::vector<std::size_t>& records) const;
  void update_loop_weight();
  [[nodiscard]] bool significant(double gain, const std::vector<float>& views) const;
  void note_times(const TrialResult& trial);
  void reject(SiftedLoop* record, Reason reason) const;
  void report(std::size_t done, std::size_t of) const;

  SifterOptions options_;
  MapScorer* scorer_;
  MapTrial trial_;
  TrialResult base_;                            // the odometry's map
  TrialResult best_;                            // with the accepted loops
  std::vector<float> base_views_, best_views_;  // base's and best map's score by view
  std::vector<SiftedLoop> records_;
  std::vector<std::size_t> accepted_;  // indices into records_, in order of acceptance
  double loop_weight_ = 1;             // common factor of the loops' information, see update_loop_weight()
  int newest_frame_ = -1;
  SifterCounts counts_;
  LatencyHistogram solve_times_, score_times_, test_times_;
  std::function<void(std::size_t, std::size_t)> progress_;
};

}  // namespace loopsift
