// SPDX-License-Identifier: MIT
// Algorithm 1 of Zhang & Chen, "Self-optimizing loop sifting and majorization for 3D reconstruction": which
// of the proposed loops the map is better with, as an anytime process. No threshold anywhere.
//
// In: the odometry's pose graph, the scored fragments, loops. Out: a decision with its numbers for every
// loop, and the poses of the best map. One step() is one bounded piece of work, the first of these that there
// is to do:
//   score   a loop not scored yet, alone on the odometry's map                                 (lines 2–6)
//   test    the best ranked loop not tested yet, on top of the accepted ones ranked before it  (lines 7–14)
//   retest  an accepted loop before which the accepted ones changed, so that it may no longer help
//   publish when the accepted loops are all tested on one another
//   retest  a refused loop before which the accepted ones changed, so that it may help now
//   review  an accepted loop by removal: is the map better without it? (hindsight)
// A decision depends only on the accepted loops of better rank; once every loop is decided on those that are
// there, the accepted ones are what one walk through the whole ranking accepts. So the order of work changes
// when the answer comes, not what it is. What a growing map does change are the scores themselves: finish()
// measures all of them again and walks from the start, which is the batch algorithm.
//
// Capacity: SifterOptions::max_loops; see LoopList for what happens past it. Thread: back. Deterministic.
// Allocates for the solves' poses and edges.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/latency_histogram.hpp"
#include "core/base/span.hpp"
#include "core/sifter/loop_list.hpp"
#include "core/sifter/map_trial.hpp"
#include "core/sifter/view_comparison.hpp"

namespace loopsift {

struct SifterOptions {
  ScoreKind score = ScoreKind::kPosterior;
  bool hindsight = true;  ///< test accepted loops again by removal; not part of the paper, off for its tables
  bool challenge =
      true;  ///< a loop must explain its two fragments better than its neighbours do (see challenge())
  /// Views that one test looks at, at most (see ViewComparer); half as many for a loop alone. 0: all, and no
  /// test ends early. The plain score always looks at all.
  int max_views_per_test = 48;
  int max_loops = 4096;  ///< known at a time
  int max_nodes = 720;   ///< of the graph, for the fast solver
  SolveOptions solve;
};

struct SifterCounts {
  std::int64_t scored = 0, tested = 0, revoked = 0;
};

class Sifter {
 public:
  /// scorer must outlive this and hold a fragment for each of the graph's whenever one of the steps below
  /// runs.
  Sifter(const SifterOptions& options, const MapScorer& scorer, Arena& arena);

  /// The odometry's graph, after each new fragment. Accepted loops and the poses of older fragments stay; new
  /// nodes follow the last one. newest_frame goes into the records.
  void set_graph(const PoseGraph& odometry, int newest_frame);
  /// Takes loops in; the steps do the rest. One that names a fragment not in the graph waits for it.
  void add(Span<const Loop> loops);
  /// One piece of work. False when there is none.
  bool step();
  /// At most so many. True when there is more to do.
  bool work(int max_steps);
  /// Scores all loops again on the graph as it is and walks from the start. Within the limit the result is
  /// that of the batch algorithm and true is returned; past it what was published before stays, and
  /// unfinished() says how many loops were left. Loops that still wait for their fragment are refused. go_on
  /// is asked before each step; its no is as good as the limit.
  bool finish(double time_limit_s = 1e9, const std::function<bool()>& go_on = {});
  [[nodiscard]] std::int64_t unfinished() const { return unfinished_; }

  /// Not by id.
  [[nodiscard]] Span<const SiftedLoop> records() const { return loops_.records(); }
  /// The loops of the published map, by id.
  [[nodiscard]] std::vector<Loop> accepted() const;
  /// Counts the published maps; changes when the accepted loops do.
  [[nodiscard]] int epoch() const { return epoch_; }
  /// Poses of the published map, by node.
  [[nodiscard]] const std::vector<Se3>& T_map_node() const { return published_.T_map_node; }
  /// The odometry's graph with the published map's poses and the frame loops of the accepted loops.
  [[nodiscard]] PoseGraph graph() const;
  /// Newest frame in the map, as given to set_graph.
  [[nodiscard]] int newest_frame() const { return newest_frame_; }
  /// Score of the odometry's map, and of the best one where the last step tested.
  [[nodiscard]] double base_score() const { return base_score_; }
  [[nodiscard]] double best_score() const { return best_score_; }
  [[nodiscard]] const SifterCounts& counts() const { return counts_; }
  /// Loops not decided on the present graph; after finish(), those it did not get to.
  [[nodiscard]] std::int64_t pending() const { return undecided(); }
  [[nodiscard]] std::int64_t dropped() const { return loops_.dropped(); }
  /// As LoopList::take_dropped.
  [[nodiscard]] bool take_dropped(SiftedLoop* record) { return loops_.take_dropped(record); }
  [[nodiscard]] std::size_t capacity() const { return loops_.capacity(); }
  /// Times of solves, scores and whole tests.
  [[nodiscard]] const LatencyHistogram& solve_times() const { return solve_times_; }
  [[nodiscard]] const LatencyHistogram& score_times() const { return score_times_; }
  [[nodiscard]] const LatencyHistogram& test_times() const { return test_times_; }
  /// Called after each step that scored or tested a loop: how many are decided on the present graph, of how
  /// many.
  void on_progress(std::function<void(std::size_t, std::size_t)> callback) {
    progress_ = std::move(callback);
  }

 private:
  /// What there is to do next, and for which loop.
  struct Work {
    enum Kind { kNone, kScore, kTest, kPublish, kReview } kind = kNone;
    std::size_t record = 0;
  };
  using Records = std::vector<std::size_t>;  // indices into the list, by rank

  [[nodiscard]] Work next_work() const;
  [[nodiscard]] bool in_map(const Loop& loop) const;
  [[nodiscard]] bool is_known(const Loop& loop) const;
  [[nodiscard]] Records accepted_before(int rank) const;
  [[nodiscard]] std::uint64_t name_of(const Records& records) const;

  void score_alone(std::size_t record);
  void test(std::size_t record);
  void review();
  void publish();
  [[nodiscard]] Reason judge(SiftedLoop* record, const TrialMap& with);
  [[nodiscard]] Reason judge_plain(SiftedLoop* record, const TrialMap& with);
  [[nodiscard]] bool withstands_challenge(const Loop& loop) const;
  [[nodiscard]] double gain_without(const TrialMap& map);
  [[nodiscard]] ViewComparison compare(Reference reference, const TrialMap& map, double prior_gain,
                                       const ComparisonLimits& limits);

  void measure_base();
  void go_to(const Records& accepted);
  void take_as_best(TrialMap map, Records accepted, double score);
  [[nodiscard]] double score_of(const Records& accepted, const TrialMap& map) const;
  [[nodiscard]] TrialMap solve_with(const std::vector<Edge>& edges, const std::vector<Se3>& start);
  void append_edges(const Loop& loop, std::vector<Edge>* edges) const;
  [[nodiscard]] std::vector<Edge> frame_loops_of(const Records& records) const;
  void update_loop_weight();
  void decide(SiftedLoop* record, Decision decision, Reason reason) const;
  void refuse(SiftedLoop* record, Reason reason) const;
  [[nodiscard]] std::int64_t undecided() const;

  SifterOptions options_;
  SolverWorkspace workspace_;
  MapLikelihood likelihood_;
  MapTrial trial_;
  ViewComparer comparer_;
  LoopList loops_;
  double loop_weight_ = 1;  // common factor of the loops' information, see update_loop_weight()
  int newest_frame_ = -1;

  // The odometry's map.
  TrialMap base_;
  double base_score_ = 0;
  // The map that loops are tested on: with these loops accepted.
  TrialMap best_;
  double best_score_ = 0;
  Records best_accepted_;
  bool best_known_ = false;  // false: the graph changed since

  TrialMap published_;
  Records published_accepted_;
  std::uint64_t published_set_ = 0;  // names the accepted loops of the published map
  std::uint64_t reviewed_set_ = 0;   // … and those under review
  std::size_t review_left_ = 0;      // of them, to be tested by removal
  int epoch_ = 0;
  bool finishing_ = false;

  SifterCounts counts_;
  std::int64_t unfinished_ = 0;
  LatencyHistogram solve_times_, score_times_, test_times_;
  std::function<void(std::size_t, std::size_t)> progress_;
};

}  // namespace loopsift
