// SPDX-License-Identifier: MIT
#include "core/pipeline/back_end.hpp"

#include "core/base/heap_watch.hpp"
#include "core/base/steady_time.hpp"

namespace loopsift {

BackEnd::BackEnd(const BackEndOptions& options, Arena& arena)
    : options_(options),
      scorer_(options.posterior, arena),
      proposer_(options.proposal, arena),
      sifter_(options.sifter, scorer_),
      calibration_(options.proposal.cloud, options.proposal.icp) {}

bool BackEnd::insert_fragment(const Fragment& fragment) {
  if (fragments_left_out_ > 0 || fragment.frames.empty() || !scorer_.add(fragment)) {
    ++fragments_left_out_;
    return false;
  }
  const Fragment* previous = fragments_.empty() ? nullptr : fragments_.back();
  append_fragment(previous, fragment, options_.keyframes_per_fragment, &graph_);
  fragments_.push_back(&fragment);
  if (options_.calibrate_odometry && !within_fence([&] { calibration_.add(fragment, graph_); }))
    ++registrations_refused_;
  return true;
}

void BackEnd::update_sifter() {
  calibrated_graph_ = graph_;
  const double factor = calibration_.covariance_factor();
  for (Edge& edge : calibrated_graph_.odometry) edge.information /= factor;
  const Fragment& newest = *fragments_.back();
  sifter_.set_graph(calibrated_graph_, newest.frames[newest.frames.size() - 1].frame.value);
}

bool BackEnd::add_fragment(const Fragment& fragment) {
  if (!insert_fragment(fragment)) return false;
  update_sifter();
  if (options_.propose) {
    const std::int64_t start = steady_now_ns();
    const std::size_t before = proposals_.size();
    const std::vector<Se3> poses = T_map_fragment();
    if (!within_fence([&] {
          proposer_.add_fragment(fragment);
          proposer_.propose(fragment.id, poses, &proposals_);
        }))
      ++registrations_refused_;  // what was proposed before memory ran out stays
    proposal_times_.record_ns(steady_now_ns() - start);
    sifter_.add(Span<const Loop>(proposals_.data() + before, proposals_.size() - before));
  }
  const std::int64_t revoked = sifter_.counts().revoked;
  const int accepted = sifter_.walk(true);
  if (accepted > 0) (void)sifter_.review();
  return accepted > 0 || sifter_.counts().revoked != revoked;
}

void BackEnd::add_loops(Span<const Loop> loops) {
  proposals_.insert(proposals_.end(), loops.begin(), loops.end());
  sifter_.add(loops);
}

void BackEnd::finish() {
  (void)sifter_.walk(false);
  (void)sifter_.review();
}

std::vector<Se3> BackEnd::T_map_fragment() const { return fragment_poses(graph_, sifter_.T_map_node()); }

Se3 BackEnd::T_map_odom() const {
  if (fragments_.empty()) return {};
  return sifter_.T_map_node().back() * graph_.T_map_node.back().inverse();
}

double BackEnd::dmp_odometry() const {
  const std::vector<Se3> poses = fragment_poses(graph_, graph_.T_map_node);
  return scorer_.score(poses, ScoreKind::kPlain).value;
}

double BackEnd::dmp_final() const {
  const std::vector<Se3> poses = T_map_fragment();
  return scorer_.score(poses, ScoreKind::kPlain).value;
}

}  // namespace loopsift
