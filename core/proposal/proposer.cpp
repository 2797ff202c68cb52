// SPDX-License-Identifier: MIT
#include "core/proposal/proposer.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

constexpr float kFieldReach = 0.20F;                 // m, how far a partner is ever looked for
constexpr int kMaxFieldCells = 1 << 20;              // 4 MiB; larger fragments get larger cells
constexpr float kRepeatMotion = 0.5F * kFieldReach;  // of an estimate that is worth another registration
constexpr float kFeatureUnit = 1 / 255.0F;           // of a stored feature; features lie in [0, 1]

float distance(const Fpfh& a, const Fpfh& b) {
  float sum = 0;
  for (std::size_t d = 0; d < a.size(); ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return std::sqrt(sum);
}

}  // namespace

bool same_motion(const Se3& a, const Se3& b, const ProposalOptions& options) {
  const Se3 difference = a.inverse() * b;
  return difference.translation().norm() < static_cast<double>(options.same_translation_m) &&
         difference.angle() < static_cast<double>(options.same_rotation_rad);
}

Proposer::Proposer(const ProposalOptions& options, Arena& arena)
    : options_(options),
      tried_(options.max_fragments, arena),
      thinner_(options.cloud),
      extractor_(options.features),
      global_(options.global) {
  const auto fragments = static_cast<std::size_t>(options.max_fragments);
  const std::size_t keypoints = fragments * static_cast<std::size_t>(options.features.max_keypoints);
  keypoint_store_ = arena.carve<std::uint16_t>("proposal/keypoints", keypoints);
  feature_store_ = arena.carve<std::uint8_t>("proposal/features", keypoints * kFpfhSize);
  sample_store_ = arena.carve<Eigen::Vector3f>("proposal/samples", fragments * kSamples);
  entries_.reserve(fragments);
  candidates_.reserve(fragments);
  repeats_.reserve(static_cast<std::size_t>(options.max_repeats_per_fragment) + 1);
}

const Proposer::Entry* Proposer::find(FragmentId id) const {
  const auto at = std::lower_bound(entries_.begin(), entries_.end(), id,
                                   [](const Entry& e, FragmentId wanted) { return e.fragment->id < wanted; });
  return at != entries_.end() && at->fragment->id == id ? &*at : nullptr;
}

bool Proposer::add_fragment(const Fragment& fragment) {
  const bool in_order = entries_.empty() || entries_.back().fragment->id < fragment.id;
  if (entries_.size() >= static_cast<std::size_t>(options_.max_fragments) || !in_order) {
    ++counts_.refused_fragments;
    return false;
  }
  thinner_.thin(fragment.surfels, &source_cloud_);
  extractor_.extract(source_cloud_, &keypoints_);
  store(fragment);
  ++counts_.fragments;
  return true;
}

/// Moves what was just computed into the arena, features as bytes.
void Proposer::store(const Fragment& fragment) {
  const std::size_t slot = entries_.size();
  const std::size_t first = slot * static_cast<std::size_t>(options_.features.max_keypoints);
  Entry entry;
  entry.fragment = &fragment;
  entry.keypoints = Span<std::uint16_t>(keypoint_store_.data() + first, keypoints_.size());
  entry.features =
      Span<std::uint8_t>(feature_store_.data() + first * kFpfhSize, keypoints_.size() * kFpfhSize);
  entry.mean = keypoints_.mean;
  std::copy(keypoints_.points.begin(), keypoints_.points.end(), entry.keypoints.begin());
  for (std::size_t k = 0; k < keypoints_.size(); ++k)
    for (std::size_t d = 0; d < kFpfhSize; ++d)
      entry.features[k * kFpfhSize + d] =
          static_cast<std::uint8_t>(keypoints_.features[k][d] / kFeatureUnit + 0.5F);
  const std::size_t samples = std::min<std::size_t>(kSamples, source_cloud_.size());
  entry.samples = Span<Eigen::Vector3f>(sample_store_.data() + slot * kSamples, samples);
  for (std::size_t k = 0; k < samples; ++k)
    entry.samples[k] = source_cloud_.points[k * source_cloud_.size() / samples];
  for (const Eigen::Vector3f& p : entry.samples) entry.center += p / static_cast<float>(samples);
  for (const Eigen::Vector3f& p : entry.samples)
    entry.radius = std::max(entry.radius, (p - entry.center).norm());
  entries_.push_back(entry);
}

void Proposer::load_features(const Entry& entry, std::vector<Fpfh>* features) {
  features->resize(entry.keypoints.size());
  for (std::size_t k = 0; k < features->size(); ++k)
    for (std::size_t d = 0; d < kFpfhSize; ++d)
      (*features)[k][d] = kFeatureUnit * static_cast<float>(entry.features[k * kFpfhSize + d]);
}

void Proposer::prepare_target(const Entry& newest) {
  thinner_.thin(newest.fragment->surfels, &target_cloud_);
  field_.build(target_cloud_.points, kFieldReach, options_.cloud.voxel_m, kMaxFieldCells);
  load_features(newest, &features_);
  matcher_.set_target(features_);
}

// No odometry edge says how a fragment after a loss of tracking hangs together with the one before.
bool Proposer::are_neighbours(std::size_t entry, std::size_t later) const {
  const Fragment& second = *entries_[later].fragment;
  return entries_[entry].fragment->id.index() + 1 == second.id.index() && second.joined_to_previous;
}

/// The part of the entry's points that have a partner in the target, on average over the estimate and the six
/// motions that are off by one standard deviation along an axis (a cubature of the normal distribution).
float Proposer::expected_overlap(const Entry& entry, const Se3& T_target_entry, float drift_m) const {
  const Se3f T(T_target_entry);
  const auto near_at = [&](const Eigen::Vector3f& offset) {
    return std::count_if(entry.samples.begin(), entry.samples.end(), [&](const Eigen::Vector3f& p) {
      return field_.nearest(T * p + offset) != NearestField::kNone;
    });
  };
  if (entry.samples.empty()) return 0.0F;
  auto near = near_at(Eigen::Vector3f::Zero());
  int motions = 1;
  for (int axis = 0; axis < 3 && drift_m > options_.cloud.voxel_m; ++axis, motions += 2)
    near += near_at(drift_m * Eigen::Vector3f::Unit(axis)) + near_at(-drift_m * Eigen::Vector3f::Unit(axis));
  return static_cast<float>(near) /
         static_cast<float>(entry.samples.size() * static_cast<std::size_t>(motions));
}

/// The pairs to try. When there are more than may be tried, half are those that overlap most under the
/// current estimate and its uncertainty, half those that look most alike, so that small and large drifts are
/// both caught.
void Proposer::choose_candidates(const Entry& newest, Span<const Se3> T_map_fragment,
                                 Span<const float> drift_m) {
  candidates_.clear();
  const std::size_t newest_index = newest.fragment->id.index();
  const auto newest_entry = static_cast<std::size_t>(&newest - entries_.data());
  for (std::size_t e = 0; e < newest_entry; ++e) {
    if (are_neighbours(e, newest_entry)) continue;
    const std::size_t index = entries_[e].fragment->id.index();
    Candidate candidate{e, 0, distance(entries_[e].mean, newest.mean)};
    if (newest_index < T_map_fragment.size()) {
      const Se3 T_newest_entry = T_map_fragment[newest_index].inverse() * T_map_fragment[index];
      const float drift = index < drift_m.size() ? drift_m[index] : 0.0F;
      candidate.expected_overlap = expected_overlap(entries_[e], T_newest_entry, drift);
    }
    candidates_.push_back(candidate);
  }
  const auto limit = static_cast<std::size_t>(options_.max_registrations_per_fragment);
  if (candidates_.size() > limit) {
    const auto half = candidates_.begin() + static_cast<std::ptrdiff_t>(limit / 2);
    std::stable_sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.expected_overlap > b.expected_overlap;
    });
    std::stable_sort(half, candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.descriptor_distance < b.descriptor_distance;
    });
    counts_.pairs_skipped += static_cast<std::int64_t>(candidates_.size() - limit);
    candidates_.resize(limit);
  }
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.entry < b.entry; });
}

/// Motions T_newest_earlier by features alone, into hypotheses_.
void Proposer::find_motions(const Entry& newest, const Entry& earlier) {
  load_features(earlier, &features_);
  matcher_.match(features_, options_.max_matches, &matches_);
  target_matched_.clear();
  source_matched_.clear();
  for (const Match& m : matches_) {
    const std::size_t t = newest.keypoints[m.target], s = earlier.keypoints[m.source];
    target_matched_.points.push_back(target_cloud_.points[t]);
    target_matched_.normals.push_back(target_cloud_.normals[t]);
    source_matched_.points.push_back(source_cloud_.points[s]);
    source_matched_.normals.push_back(source_cloud_.normals[s]);
  }
  global_.run(target_matched_, source_matched_, &hypotheses_);
}

/// Appends a result as a loop unless it is weak or the pair already has that motion.
void Proposer::keep(const IcpResult& result, bool good_enough, FragmentId earlier, FragmentId newest,
                    std::size_t first_of_pair, std::vector<Loop>* out) {
  const auto smaller = static_cast<float>(std::min(source_cloud_.size(), target_cloud_.size()));
  const float overlap = std::min(1.0F, static_cast<float>(result.partners) / smaller);
  if (!good_enough || overlap < options_.min_overlap) return;
  Loop loop;
  loop.i = earlier;
  loop.j = newest;
  loop.T_i_j = result.T_target_source.inverse();
  for (std::size_t k = first_of_pair; k < out->size(); ++k)
    if (same_motion((*out)[k].T_i_j, loop.T_i_j, options_)) return;
  // (T exp(ξ))⁻¹ = T⁻¹ exp(−Ad(T) ξ), so ξ = −Ad(T⁻¹) η with η the perturbation of T_i_j = T⁻¹.
  const Matrix6d Ad = loop.T_i_j.adjoint();
  loop.information = Ad.transpose() * result.information * Ad;
  loop.overlap = overlap;
  loop.residual_m = result.residual_m;
  loop.id.value = static_cast<std::int32_t>(counts_.proposed++);
  out->push_back(loop);
}

void Proposer::try_pair(const Candidate& candidate, const Entry& newest, Span<const Se3> T_map_fragment,
                        std::vector<Loop>* out) {
  ++counts_.pairs_tried;
  const Entry& earlier = entries_[candidate.entry];
  const FragmentId i = earlier.fragment->id, j = newest.fragment->id;
  thinner_.thin(earlier.fragment->surfels, &source_cloud_);
  const IcpTarget target{&target_cloud_, &field_};
  const std::size_t first_of_pair = out->size();

  find_motions(newest, earlier);
  IcpResult best;
  for (const MotionHypothesis& h : hypotheses_) {
    const IcpResult result = refine(options_.icp, target, source_cloud_, h.T_target_source);
    if (result.ok && result.partners > best.partners) best = result;
  }
  keep(best, best.ok, i, j, first_of_pair, out);

  if (j.index() >= T_map_fragment.size()) return;
  const auto target_entry = static_cast<std::size_t>(&newest - entries_.data());
  const Se3 T_j_i = T_map_fragment[j.index()].inverse() * T_map_fragment[i.index()];
  tried_.set(candidate.entry, target_entry, T_j_i);
  if (candidate.expected_overlap < options_.min_expected_overlap) return;
  ++counts_.estimates_tried;
  const IcpResult result = refine(options_.icp, target, source_cloud_, T_j_i);
  keep(result, result.fits, i, j, first_of_pair, out);
}

void Proposer::propose(FragmentId newest_id, Span<const Se3> T_map_fragment, Span<const float> drift_m,
                       std::vector<Loop>* out) {
  const Entry* newest = find(newest_id);
  if (newest == nullptr) return;
  prepare_target(*newest);
  if (target_cloud_.size() < static_cast<std::size_t>(options_.icp.min_partners)) return;
  choose_candidates(*newest, T_map_fragment, drift_m);
  for (const Candidate& candidate : candidates_) {
    if (stopped()) return;
    try_pair(candidate, *newest, T_map_fragment, out);
  }
}

/// Pairs that may overlap under this estimate, and whose estimate is another than when they were last tried.
void Proposer::choose_repeats(Span<const Se3> T_map_fragment) {
  repeats_.clear();
  const auto limit = static_cast<std::size_t>(options_.max_repeats_per_fragment);
  for (std::size_t target = 1; target < entries_.size(); ++target) {
    const Entry& later = entries_[target];
    if (later.fragment->id.index() >= T_map_fragment.size()) break;
    const Se3 T_later_map = T_map_fragment[later.fragment->id.index()].inverse();
    for (std::size_t e = 0; e < target; ++e) {
      const Entry& earlier = entries_[e];
      if (are_neighbours(e, target)) continue;
      const Se3 T_later_earlier = T_later_map * T_map_fragment[earlier.fragment->id.index()];
      const Eigen::Vector3f center = (T_later_earlier * earlier.center.cast<double>()).cast<float>();
      const float apart = (center - later.center).norm() / (earlier.radius + later.radius);
      const bool may_overlap = apart < 1.0F && (repeats_.size() < limit || apart < repeats_.back().apart);
      if (!may_overlap) continue;
      if (tried_.moved(e, target, T_later_earlier, earlier.center, earlier.radius) < kRepeatMotion) continue;
      const Repeat repeat{e, target, apart};
      const auto at = std::upper_bound(repeats_.begin(), repeats_.end(), repeat,
                                       [](const Repeat& a, const Repeat& b) { return a.apart < b.apart; });
      repeats_.insert(at, repeat);
      if (repeats_.size() > limit) repeats_.pop_back();
    }
  }
}

void Proposer::propose_again(Span<const Se3> T_map_fragment, std::vector<Loop>* out) {
  choose_repeats(T_map_fragment);
  for (const Repeat& repeat : repeats_) {
    if (stopped()) return;
    const Entry &earlier = entries_[repeat.entry], &later = entries_[repeat.target];
    const FragmentId i = earlier.fragment->id, j = later.fragment->id;
    const Se3 T_j_i = T_map_fragment[j.index()].inverse() * T_map_fragment[i.index()];
    ++counts_.pairs_repeated;
    tried_.set(repeat.entry, repeat.target, T_j_i);
    prepare_target(later);
    if (expected_overlap(earlier, T_j_i, 0.0F) < options_.min_expected_overlap) continue;
    thinner_.thin(earlier.fragment->surfels, &source_cloud_);
    const IcpResult result = refine(options_.icp, {&target_cloud_, &field_}, source_cloud_, T_j_i);
    keep(result, result.fits, i, j, out->size(), out);
  }
}

}  // namespace loopsift
