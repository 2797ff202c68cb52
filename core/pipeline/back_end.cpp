// SPDX-License-Identifier: MIT
#include "core/pipeline/back_end.hpp"

#include <algorithm>

#include "core/base/heap_watch.hpp"
#include "core/base/steady_time.hpp"
#include "core/posegraph/chain_drift.hpp"

namespace loopsift {
namespace {

SifterOptions sifter_options(const BackEndOptions& options) {
  SifterOptions sifter = options.sifter;
  sifter.max_nodes = options.posterior.max_fragments * options.keyframes_per_fragment;
  return sifter;
}

}  // namespace

BackEnd::BackEnd(const BackEndOptions& options, Arena& arena)
    : options_(options),
      scorer_(options.posterior, arena),
      proposer_(options.proposal, arena),
      sifter_(sifter_options(options), scorer_, arena),
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
  if (!options_.propose) return true;
  const std::int64_t start = steady_now_ns();
  const std::vector<Se3> poses = T_map_fragment();
  const std::vector<float> drift_m = drift_to_newest(calibrated_graph_);
  proposed_.clear();
  if (!within_fence([&] {
        proposer_.add_fragment(fragment);
        proposer_.propose(fragment.id, poses, drift_m, &proposed_);
        propose_again(poses);
      }))
    ++registrations_refused_;  // what was proposed before memory ran out stays
  proposal_times_.record_ns(steady_now_ns() - start);
  add_loops(Span<const Loop>(proposed_.data(), proposed_.size()));
  return true;
}

// Registered from two estimates, a pair often gives the same motion twice.
void BackEnd::propose_again(Span<const Se3> T_map_fragment) {
  const std::size_t first = proposed_.size();
  proposer_.propose_again(T_map_fragment, &proposed_);
  const auto is_known = [this](const Loop& loop) {
    const auto& records = sifter_.records();
    return std::any_of(records.begin(), records.end(), [&](const SiftedLoop& r) {
      return r.loop.i == loop.i && r.loop.j == loop.j &&
             same_motion(r.loop.T_i_j, loop.T_i_j, options_.proposal);
    });
  };
  const auto begin = proposed_.begin() + static_cast<std::ptrdiff_t>(first);
  proposed_.erase(std::remove_if(begin, proposed_.end(), is_known), proposed_.end());
}

void BackEnd::add_loops(Span<const Loop> loops) {
  std::vector<Loop> numbered(loops.begin(), loops.end());
  for (Loop& loop : numbered) {
    if (!loop.id.valid() || (loop.id.value < next_loop_id_ && id_is_taken(loop.id)))
      loop.id.value = next_loop_id_;
    next_loop_id_ = std::max(next_loop_id_, loop.id.value + 1);
  }
  sifter_.add(Span<const Loop>(numbered.data(), numbered.size()));
}

bool BackEnd::id_is_taken(LoopId id) const {
  const auto& records = sifter_.records();
  return std::any_of(records.begin(), records.end(), [id](const SiftedLoop& r) { return r.loop.id == id; });
}

std::vector<Loop> BackEnd::proposals() const {
  std::vector<Loop> loops;
  for (const SiftedLoop& record : sifter_.records()) loops.push_back(record.loop);
  std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) { return a.id < b.id; });
  return loops;
}

std::vector<Se3> BackEnd::T_map_fragment() const { return fragment_poses(graph_, sifter_.T_map_node()); }

Se3 BackEnd::T_map_odom() const {
  if (fragments_.empty()) return {};
  return sifter_.T_map_node().back() * graph_.T_map_node.back().inverse();
}

bool BackEnd::anchored() const {
  const PoseGraph graph = sifter_.graph();
  return graph.nodes.empty() || joined(graph, 0, static_cast<int>(graph.nodes.size()) - 1);
}

FrameId BackEnd::piece() const {
  std::size_t first = fragments_.size();
  if (first == 0) return {};
  do --first;
  while (first > 0 && fragments_[first]->joined_to_previous);
  return fragments_[first]->frames[0].frame;
}

double BackEnd::dmp_odometry() const {
  const std::vector<Se3> poses = fragment_poses(graph_, graph_.T_map_node);
  return scorer_.dmp(poses).value;
}

double BackEnd::dmp_final() const {
  const std::vector<Se3> poses = T_map_fragment();
  return scorer_.dmp(poses).value;
}

}  // namespace loopsift
