// SPDX-License-Identifier: MIT
#include "core/sifter/sifter.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/latency_timer.hpp"
#include "core/base/steady_time.hpp"
#include "core/sifter/challenge.hpp"

namespace loopsift {
namespace {

// Names a list of loops, from the name of the list without the last one (Fowler–Noll–Vo 1a, by ids).
constexpr std::uint64_t kNoLoops = 0xcbf29ce484222325ULL;
std::uint64_t with_loop(std::uint64_t set, LoopId id) {
  return (set ^ static_cast<std::uint64_t>(id.value + 1)) * 0x100000001b3ULL;
}

// Decided on the graph as it is, and accepted.
bool stands(const SiftedLoop& record) {
  return record.decision == Decision::kAccepted && record.tested_on != 0;
}

SolverLimits solver_limits(int max_nodes) { return {max_nodes, 6 * max_nodes}; }

}  // namespace

Sifter::Sifter(const SifterOptions& options, const MapScorer& scorer, Arena& arena)
    : options_(options),
      workspace_(&arena, solver_limits(options.max_nodes)),
      likelihood_(scorer, arena),
      trial_(scorer, options.score, options.solve, workspace_),
      loops_(static_cast<std::size_t>(options.max_loops), arena),
      published_set_(kNoLoops) {}

void Sifter::set_graph(const PoseGraph& odometry, int newest_frame) {
  newest_frame_ = newest_frame;
  trial_.set_graph(odometry);
  measure_base();
  std::vector<Se3> start = published_.T_map_node;
  for (std::size_t n = start.size(); n < odometry.T_map_node.size(); ++n) {
    start.push_back(n == 0 ? odometry.T_map_node[0]
                           : start.back() * odometry.T_map_node[n - 1].inverse() * odometry.T_map_node[n]);
  }
  published_ = published_accepted_.empty() ? base_ : solve_with(frame_loops_of(published_accepted_), start);
}

void Sifter::add(Span<const Loop> loops) {
  for (const Loop& loop : loops) {
    const bool known = is_known(loop);
    if (!loops_.add(loop)) continue;
    SiftedLoop& record = loops_.newest();
    const bool possible = loop.i.valid() && loop.j.valid() && loop.i != loop.j;
    if (!possible || known) {
      refuse(&record, known ? Reason::kSame : Reason::kNoFragment);
    } else if (!in_map(loop)) {
      record.reason = Reason::kWaits;
    }
  }
  update_loop_weight();
}

// What proposers claim about their loops is right up to a factor that nobody knows; a loop that is too weak
// is a nudge in a random direction, one that is too stiff bends the odometry to its own error. What the map
// knows is its own residual b: the posterior weighs the loops so that their median claims a position to
// within b. Relative weights stay as claimed.
void Sifter::update_loop_weight() {
  if (options_.score != ScoreKind::kPosterior) return;
  std::vector<double> information;
  for (const SiftedLoop& r : loops_.records()) {
    const double mean = r.loop.information.topLeftCorner<3, 3>().trace() / 3.0;
    if (std::isfinite(mean)) information.push_back(mean);
  }
  if (information.empty()) return;
  const auto middle = information.begin() + static_cast<std::ptrdiff_t>(information.size() / 2);
  std::nth_element(information.begin(), middle, information.end());
  const double b = trial_.scorer().own_residual();
  if (*middle > 0 && b > 0) loop_weight_ = 1.0 / (b * b * *middle);
}

// Twice the same measurement is not twice the information.
bool Sifter::is_known(const Loop& loop) const {
  const auto& records = loops_.records();
  return std::any_of(records.begin(), records.end(), [&loop](const SiftedLoop& r) {
    return r.loop.i == loop.i && r.loop.j == loop.j && r.loop.T_i_j.matrix() == loop.T_i_j.matrix();
  });
}

bool Sifter::in_map(const Loop& loop) const {
  const int fragments = trial_.graph().fragment_count();
  return loop.i.valid() && loop.j.valid() && loop.i != loop.j && loop.i.value < fragments &&
         loop.j.value < fragments;
}

Sifter::Work Sifter::next_work() const {
  for (std::size_t k = 0; k < loops_.size(); ++k)
    if (!loops_[k].scored && loops_[k].reason != Reason::kSame && in_map(loops_[k].loop))
      return {Work::kScore, k};

  Work untested, doubtful, stale;
  std::uint64_t set = kNoLoops;
  std::size_t accepted = 0;
  for (const std::size_t k : loops_.ranking()) {
    const SiftedLoop& record = loops_[k];
    Work* work = record.tested_on == 0 ? &untested : stands(record) ? &doubtful : &stale;
    if (work->kind == Work::kNone && record.tested_on != set) *work = {Work::kTest, k};
    if (!stands(record)) continue;
    set = with_loop(set, record.loop.id);
    ++accepted;
  }
  if (doubtful.kind != Work::kNone) return doubtful;
  if (set != published_set_ && !finishing_) return {Work::kPublish, 0};
  if (untested.kind != Work::kNone) return untested;
  if (stale.kind != Work::kNone) return stale;
  if (options_.hindsight && accepted > 0 && (set != reviewed_set_ || review_left_ > 0))
    return {Work::kReview, 0};
  return {};
}

bool Sifter::step() {
  const Work work = next_work();
  switch (work.kind) {
    case Work::kNone:
      return false;
    case Work::kScore:
      score_alone(work.record);
      break;
    case Work::kTest:
      test(work.record);
      break;
    case Work::kPublish:
      publish();
      break;
    case Work::kReview:
      review();
      break;
  }
  if (progress_) progress_(loops_.size() - static_cast<std::size_t>(undecided()), loops_.size());
  return true;
}

bool Sifter::work(int max_steps) {
  for (int k = 0; k < max_steps; ++k)
    if (!step()) return false;
  return true;
}

// Lines 3–5: T ← optimize(G, O[i]); M ← fuseModel(T, Z); r[i] ← r(M, Z).
void Sifter::score_alone(std::size_t k) {
  SiftedLoop& record = loops_[k];
  record.scored = true;
  ++counts_.scored;
  std::vector<Edge> edges;
  append_edges(record.loop, &edges);
  const TrialMap alone = solve_with(edges, base_.T_map_node);
  if (!alone.solved) return refuse(&record, Reason::kSolveFailed);
  if (options_.score == ScoreKind::kPlain) {
    const LatencyTimer timer(&score_times_);
    record.improvement = base_score_ - trial_.scorer().dmp(alone.T_map_fragment).value;
  } else {
    const ComparisonLimits limits{options_.max_views_per_test / 2, options_.max_views_per_test > 0};
    record.improvement = compare(Reference::kOdometry, alone, -alone.prior, limits).gain;
  }
  record.single_score = base_score_ - record.improvement;
  record.reason = Reason::kNotTested;
  loops_.rank(k);
}

// Lines 9–14: accepted only if r' > r*, that is, if the score falls.
void Sifter::test(std::size_t k) {
  SiftedLoop& record = loops_[k];
  Records accepted = accepted_before(record.rank);
  go_to(accepted);
  const std::int64_t start = steady_now_ns();
  record.tested_on = name_of(accepted);
  record.best_score_before = best_score_;
  ++counts_.tested;
  std::vector<Edge> edges = frame_loops_of(accepted);
  append_edges(record.loop, &edges);
  TrialMap with = solve_with(edges, best_.T_map_node);
  const Reason reason = with.solved ? judge(&record, with) : Reason::kSolveFailed;
  test_times_.record_ns(steady_now_ns() - start);
  if (reason != Reason::kImproves) return refuse(&record, reason);
  decide(&record, Decision::kAccepted, reason);
  accepted.push_back(k);
  take_as_best(std::move(with), std::move(accepted), record.tested_score);
}

Reason Sifter::judge(SiftedLoop* record, const TrialMap& with) {
  if (options_.score == ScoreKind::kPlain) return judge_plain(record, with);
  const ComparisonLimits limits{options_.max_views_per_test, options_.max_views_per_test > 0};
  const ViewComparison comparison = compare(Reference::kBest, with, best_.prior - with.prior, limits);
  record->tested_score = best_score_ - comparison.gain;
  record->views = comparison.views;
  if (comparison.views == 0) return Reason::kNoChange;
  if (!(comparison.gain > 0)) return Reason::kNoImprovement;
  if (!comparison.significant()) return Reason::kInsignificant;
  return withstands_challenge(record->loop) ? Reason::kImproves : Reason::kChallenged;
}

bool Sifter::withstands_challenge(const Loop& loop) const {
  if (!options_.challenge) return true;
  PoseGraph graph = trial_.graph();
  graph.loops = frame_loops_of(best_accepted_);
  const bool joined =
      loopsift::joined(graph, graph.first_node[loop.i.index()], graph.first_node[loop.j.index()]);
  return loopsift::withstands_challenge(trial_.scorer(), loop, best_.T_map_fragment, joined);
}

Reason Sifter::judge_plain(SiftedLoop* record, const TrialMap& with) {
  const LatencyTimer timer(&score_times_);
  const MapScore score = trial_.scorer().dmp(with.T_map_fragment, {}, best_score_);
  record->tested_score = score.value;
  record->views = score.views_rendered;
  return score.complete && score.value < best_score_ ? Reason::kImproves : Reason::kNoImprovement;
}

// How much lower the score is in a map from which something was taken.
double Sifter::gain_without(const TrialMap& map) {
  if (options_.score == ScoreKind::kPlain) return best_score_ - trial_.scorer().dmp(map.T_map_fragment).value;
  return compare(Reference::kBest, map, best_.prior - map.prior, {options_.max_views_per_test, false}).gain;
}

ViewComparison Sifter::compare(Reference reference, const TrialMap& map, double prior_gain,
                               const ComparisonLimits& limits) {
  const LatencyTimer timer(&score_times_);
  return comparer_.compare(&likelihood_, reference, map.T_map_fragment, prior_gain, limits);
}

// Tests the accepted loops by removal, the worst ranked first; begins anew when they change.
void Sifter::review() {
  const Records accepted = accepted_before(static_cast<int>(loops_.size()));
  go_to(accepted);
  const std::uint64_t set = name_of(accepted);
  if (set != reviewed_set_) {
    reviewed_set_ = set;
    review_left_ = accepted.size();
  }
  Records rest = accepted;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(--review_left_));
  TrialMap without = solve_with(frame_loops_of(rest), best_.T_map_node);
  if (!without.solved) return;
  const double gain = gain_without(without);
  if (!(gain > 0)) return;
  refuse(&loops_[accepted[review_left_]], Reason::kBetterWithout);
  review_left_ = 0;
  take_as_best(std::move(without), std::move(rest), best_score_ - gain);
}

void Sifter::publish() {
  const Records accepted = accepted_before(static_cast<int>(loops_.size()));
  go_to(accepted);
  for (const std::size_t k : published_accepted_) loops_[k].published = false;
  for (const std::size_t k : accepted) loops_[k].published = true;
  published_set_ = name_of(accepted);
  for (const std::size_t k : published_accepted_) counts_.revoked += loops_[k].published ? 0 : 1;
  published_accepted_ = accepted;
  published_ = best_;
  ++epoch_;
}

bool Sifter::finish(double time_limit_s, const std::function<bool()>& go_on) {
  const std::int64_t end = steady_now_ns() + static_cast<std::int64_t>(time_limit_s * 1e9);
  const std::vector<SiftedLoop> before = loops_.snapshot();
  finishing_ = true;
  update_loop_weight();
  measure_base();
  loops_.start_again();
  reviewed_set_ = 0;
  bool more = true;
  while (more && steady_now_ns() < end && (!go_on || go_on())) more = step();
  finishing_ = false;
  unfinished_ = more ? undecided() : 0;
  if (more) {
    loops_.restore(before);
    best_known_ = false;
    return false;
  }
  for (std::size_t k = 0; k < loops_.size(); ++k)
    if (loops_[k].reason == Reason::kWaits) refuse(&loops_[k], Reason::kNoFragment);
  if (trial_.graph().fragment_count() > 0) publish();
  return true;
}

// What single loops are measured against.
void Sifter::measure_base() {
  base_ = trial_.base();
  base_score_ = options_.score == ScoreKind::kPlain ? trial_.scorer().dmp(base_.T_map_fragment).value
                                                    : likelihood_.set_odometry_map(base_.T_map_fragment);
  best_known_ = false;
}

// Makes the map with these loops the one that loops are tested on. Always from the odometry's map, so that it
// does not depend on what was done before.
void Sifter::go_to(const Records& accepted) {
  if (best_known_ && best_accepted_ == accepted) return;
  best_known_ = true;
  TrialMap map = accepted.empty() ? base_ : solve_with(frame_loops_of(accepted), base_.T_map_node);
  const double score = score_of(accepted, map);
  take_as_best(std::move(map), accepted, score);
}

// The posterior's is what the test of the last loop came to: a sum over all views would cost more than many
// tests, and decisions need differences only.
double Sifter::score_of(const Records& accepted, const TrialMap& map) const {
  if (accepted.empty()) return base_score_;
  if (options_.score == ScoreKind::kPlain) return trial_.scorer().dmp(map.T_map_fragment).value;
  return loops_[accepted.back()].tested_score;
}

void Sifter::take_as_best(TrialMap map, Records accepted, double score) {
  best_ = std::move(map);
  best_accepted_ = std::move(accepted);
  best_score_ = score;
  if (options_.score == ScoreKind::kPosterior) likelihood_.set_best_map(best_.T_map_fragment);
}

TrialMap Sifter::solve_with(const std::vector<Edge>& edges, const std::vector<Se3>& start) {
  const LatencyTimer timer(&solve_times_);
  return trial_.run(edges, start);
}

Sifter::Records Sifter::accepted_before(int rank) const {
  Records accepted;
  for (const std::size_t k : loops_.ranking()) {
    if (loops_[k].rank >= rank) break;
    if (stands(loops_[k])) accepted.push_back(k);
  }
  return accepted;
}

std::uint64_t Sifter::name_of(const Records& records) const {
  std::uint64_t set = kNoLoops;
  for (const std::size_t k : records) set = with_loop(set, loops_[k].loop.id);
  return set;
}

void Sifter::append_edges(const Loop& loop, std::vector<Edge>* edges) const {
  Loop weighted = loop;
  weighted.information *= loop_weight_;
  append_frame_loops(trial_.graph(), weighted, edges);
}

std::vector<Edge> Sifter::frame_loops_of(const Records& records) const {
  std::vector<Edge> edges;
  for (const std::size_t k : records) append_edges(loops_[k].loop, &edges);
  return edges;
}

std::vector<Loop> Sifter::accepted() const {
  std::vector<Loop> loops;
  for (const std::size_t k : published_accepted_) loops.push_back(loops_[k].loop);
  std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) { return a.id < b.id; });
  return loops;
}

PoseGraph Sifter::graph() const {
  PoseGraph graph = trial_.graph();
  graph.T_map_node = published_.T_map_node;
  graph.loops = frame_loops_of(published_accepted_);
  return graph;
}

std::int64_t Sifter::undecided() const {
  const auto& records = loops_.records();
  return std::count_if(records.begin(), records.end(), [](const SiftedLoop& record) {
    const bool impossible = record.reason == Reason::kSolveFailed || record.reason == Reason::kNoFragment ||
                            record.reason == Reason::kSame;
    return record.tested_on == 0 && !impossible;
  });
}

void Sifter::decide(SiftedLoop* record, Decision decision, Reason reason) const {
  if (record->decision != Decision::kPending && record->decision != decision) ++record->revisions;
  record->decision = decision;
  record->reason = reason;
  record->frame_decided = newest_frame_;
}

void Sifter::refuse(SiftedLoop* record, Reason reason) const {
  const bool was_in_map = record->published || record->decision == Decision::kRevoked;
  decide(record, was_in_map ? Decision::kRevoked : Decision::kRejected, reason);
}

}  // namespace loopsift
