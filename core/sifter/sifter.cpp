// SPDX-License-Identifier: MIT
#include "core/sifter/sifter.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/sifter/challenge.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kTellingViews = 32;  // kept per loop; the rest follow in their own order

// Views by how much worse they became, worst first; those that became better are left out.
std::vector<std::uint16_t> worsened_views(const std::vector<float>& before, const std::vector<float>& after) {
  std::vector<std::uint16_t> views;
  for (std::size_t v = 0; v < before.size(); ++v) {
    if (after[v] > before[v]) views.push_back(static_cast<std::uint16_t>(v));
  }
  std::stable_sort(views.begin(), views.end(), [&](std::uint16_t a, std::uint16_t b) {
    return after[a] - before[a] > after[b] - before[b];
  });
  views.resize(std::min(views.size(), kTellingViews));
  return views;
}

}  // namespace

const char* to_string(Decision decision) {
  switch (decision) {
    case Decision::kPending:
      return "pending";
    case Decision::kAccepted:
      return "accepted";
    case Decision::kRejected:
      return "rejected";
    case Decision::kRevoked:
      return "revoked";
  }
  return "";
}

const char* to_string(Reason reason) {
  switch (reason) {
    case Reason::kNotTested:
      return "not tested";
    case Reason::kImproves:
      return "improves the map";
    case Reason::kNoImprovement:
      return "does not improve the map";
    case Reason::kInsignificant:
      return "improves the map by less than the standard error";
    case Reason::kChallenged:
      return "a motion next to it explains the two fragments better";
    case Reason::kSolveFailed:
      return "the pose graph could not be optimised with it";
    case Reason::kBetterWithout:
      return "the map is better without it";
  }
  return "";
}

Sifter::Sifter(const SifterOptions& options, MapScorer& scorer)
    : options_(options), scorer_(&scorer), trial_(PoseGraph{}, scorer, options.score, options.solve) {}

void Sifter::set_graph(const PoseGraph& odometry, int newest_frame) {
  newest_frame_ = newest_frame;
  trial_ = MapTrial(odometry, *scorer_, options_.score, options_.solve);
  base_views_.assign(static_cast<std::size_t>(scorer_->view_count()), 0.0F);
  base_ = trial_.base();
  trial_.set_reference(base_, true);
  base_ = trial_.base(base_views_);

  std::vector<Se3> start = best_.T_map_node;
  for (std::size_t n = start.size(); n < odometry.T_map_node.size(); ++n) {
    start.push_back(n == 0 ? odometry.T_map_node[0]
                           : start.back() * odometry.T_map_node[n - 1].inverse() * odometry.T_map_node[n]);
  }
  solve_accepted(start);
}

// The map with the accepted loops; where the solve fails the poses stay as they were.
void Sifter::solve_accepted(const std::vector<Se3>& start) {
  best_views_ = base_views_;
  best_ = accepted_.empty() ? base_ : trial_.run(frame_loops_of(accepted_), start, {}, best_views_);
  if (!best_.solved) best_ = trial_.as_it_is(start, best_views_);
}

void Sifter::add(Span<const Loop> loops) {
  const std::size_t first = records_.size();
  records_.resize(first + loops.size());
  for (std::size_t k = 0; k < loops.size(); ++k) records_[first + k].loop = loops[k];
  update_loop_weight();
  trial_.set_reference(base_, true);
  for (std::size_t k = 0; k < loops.size(); ++k) {
    score_alone(&records_[first + k]);
    report(k + 1, loops.size());
  }
}

// What proposers claim about their loops is right up to a factor that nobody knows; a loop that is too weak
// is a nudge in a random direction, one that is too stiff bends the odometry to its own error. What the map
// knows is its own residual b: the posterior weighs the loops so that their median claims a position to
// within b. Relative weights stay as claimed.
void Sifter::update_loop_weight() {
  if (options_.score != ScoreKind::kPosterior || records_.empty()) return;
  std::vector<double> information;
  for (const SiftedLoop& r : records_) {
    information.push_back(r.loop.information.topLeftCorner<3, 3>().trace() / 3.0);
  }
  const auto middle = information.begin() + static_cast<std::ptrdiff_t>(information.size() / 2);
  std::nth_element(information.begin(), middle, information.end());
  const double b = scorer_->own_residual();
  if (*middle > 0 && b > 0) loop_weight_ = 1.0 / (b * b * *middle);
}

// Lines 3–5: T ← optimize(G, O[i]); M ← fuseModel(T, Z); r[i] ← r(M, Z).
void Sifter::score_alone(SiftedLoop* record) {
  const int fragments = trial_.graph().fragment_count();
  for (const FragmentId f : {record->loop.i, record->loop.j}) {
    if (!f.valid() || f.value >= fragments) return reject(record, Reason::kSolveFailed);
  }
  std::vector<Edge> edges;
  append_edges(record->loop, &edges);
  std::vector<float> views(base_views_.size());
  const TrialResult alone = trial_.run(edges, base_.T_map_node, {}, views);
  note_times(alone);
  ++counts_.scored;
  if (!alone.solved) return reject(record, Reason::kSolveFailed);
  record->single_score = alone.score;
  record->improvement = base_.score - alone.score;
  record->telling_views = worsened_views(base_views_, views);
}

// Line 7: the most effective first. Ties by id, so that the order does not depend on how they arrived.
std::vector<std::size_t> Sifter::ranked(bool pending_only) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < records_.size(); ++k) {
    const SiftedLoop& r = records_[k];
    if (r.reason == Reason::kSolveFailed) continue;
    if (!pending_only || r.decision == Decision::kPending) order.push_back(k);
  }
  std::sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
    const SiftedLoop &x = records_[a], &y = records_[b];
    return x.improvement != y.improvement ? x.improvement > y.improvement : x.loop.id < y.loop.id;
  });
  for (std::size_t k = 0; k < order.size(); ++k) records_[order[k]].rank = static_cast<int>(k);
  return order;
}

int Sifter::walk(bool pending_only) {
  if (!pending_only) {
    accepted_.clear();
    best_ = base_;
    best_views_ = base_views_;
  }
  trial_.set_reference(best_, true);
  if (!accepted_.empty()) solve_accepted(std::vector<Se3>(best_.T_map_node));
  const std::size_t before = accepted_.size();
  const std::vector<std::size_t> order = ranked(pending_only);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (test(&records_[order[k]])) accepted_.push_back(order[k]);
    report(k + 1, order.size());
  }
  return static_cast<int>(accepted_.size() - before);
}

// Lines 9–14: accepted only if r' > r*, that is, if the score falls.
bool Sifter::test(SiftedLoop* record) {
  const auto start = std::chrono::steady_clock::now();
  record->best_score_before = best_.score;
  record->frame_decided = newest_frame_;
  std::vector<Edge> edges = frame_loops_of(accepted_);
  append_edges(record->loop, &edges);
  ScoreLimits limits;
  limits.give_up_above = best_.score;
  limits.first_views = Span<const std::uint16_t>(record->telling_views.data(), record->telling_views.size());
  std::vector<float> views(best_views_.size());
  TrialResult with = trial_.run(edges, best_.T_map_node, limits, views);
  note_times(with);
  ++counts_.tested;
  record->tested_score = with.score;

  Reason reason = Reason::kImproves;
  if (!with.solved) {
    reason = Reason::kSolveFailed;
  } else if (!with.complete || !(with.score < best_.score)) {
    reason = Reason::kNoImprovement;
  } else if (options_.score == ScoreKind::kPosterior && !significant(best_.score - with.score, views)) {
    reason = Reason::kInsignificant;
  } else if (options_.challenge && options_.score == ScoreKind::kPosterior) {
    const std::vector<Se3> poses = fragment_poses(trial_.graph(), best_.T_map_node);
    if (!withstands_challenge(*scorer_, record->loop, poses)) reason = Reason::kChallenged;
  }
  test_times_.record_ns((std::chrono::steady_clock::now() - start).count());
  if (reason != Reason::kImproves) {
    reject(record, reason);
    return false;
  }
  record->decision = Decision::kAccepted;
  record->reason = reason;
  best_ = std::move(with);
  best_views_ = std::move(views);
  trial_.set_reference(best_, false);
  return true;
}

// The one-standard-error rule (Breiman et al., Classification and Regression Trees, 1984, 3.4.3): the simpler
// model, here the one without the loop, unless the gain is more than its standard error. The views are the
// samples.
bool Sifter::significant(double gain, const std::vector<float>& views) const {
  double squares = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto d = static_cast<double>(best_views_[v] - views[v]);
    squares += d * d;
  }
  return gain > std::sqrt(squares);
}

int Sifter::review() {
  if (!options_.hindsight) return 0;
  int revoked = 0;
  for (std::size_t k = accepted_.size(); k-- > 0;) {
    if (!test_removal(k)) continue;
    ++revoked;
    k = accepted_.size();  // another one may now be better left out, too
  }
  counts_.revoked += revoked;
  return revoked;
}

bool Sifter::test_removal(std::size_t accepted_index) {
  std::vector<std::size_t> rest = accepted_;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(accepted_index));
  ScoreLimits limits;
  limits.give_up_above = best_.score;
  std::vector<float> views(best_views_.size());
  TrialResult without = trial_.run(frame_loops_of(rest), best_.T_map_node, limits, views);
  note_times(without);
  if (!without.solved || !without.complete || !(without.score < best_.score)) return false;
  SiftedLoop& record = records_[accepted_[accepted_index]];
  record.decision = Decision::kRevoked;
  record.reason = Reason::kBetterWithout;
  record.frame_decided = newest_frame_;
  accepted_ = std::move(rest);
  best_ = std::move(without);
  best_views_ = std::move(views);
  trial_.set_reference(best_, false);
  return true;
}

void Sifter::append_edges(const Loop& loop, std::vector<Edge>* edges) const {
  Loop weighted = loop;
  weighted.information *= loop_weight_;
  append_frame_loops(trial_.graph(), weighted, edges);
}

std::vector<Edge> Sifter::frame_loops_of(const std::vector<std::size_t>& records) const {
  std::vector<Edge> edges;
  for (const std::size_t k : records) append_edges(records_[k].loop, &edges);
  return edges;
}

std::vector<Loop> Sifter::accepted() const {
  std::vector<Loop> loops;
  for (const std::size_t k : accepted_) loops.push_back(records_[k].loop);
  std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) { return a.id < b.id; });
  return loops;
}

PoseGraph Sifter::graph() const {
  PoseGraph graph = trial_.graph();
  graph.T_map_node = best_.T_map_node;
  graph.loops = frame_loops_of(accepted_);
  return graph;
}

void Sifter::note_times(const TrialResult& trial) {
  solve_times_.record_ns(std::llround(trial.solve_ms * 1e6));
  if (trial.solved) score_times_.record_ns(std::llround(trial.score_ms * 1e6));
}

void Sifter::reject(SiftedLoop* record, Reason reason) const {
  record->decision = Decision::kRejected;
  record->reason = reason;
  record->frame_decided = newest_frame_;
}

void Sifter::report(std::size_t done, std::size_t of) const {
  if (progress_) progress_(done, of);
}

}  // namespace loopsift
