// SPDX-License-Identifier: MIT
// Loop proposals: registrations of a new fragment against earlier ones that are not its neighbours.
// In: closed fragments, and the current estimate of their poses. Out: loops T_i_j with overlap, residual and
// information; several for one pair where several motions fit. Liberal on purpose: a proposal needs only weak
// evidence, the sifter decides. Deterministic: no random numbers.
//
// Each pair is tried from two starts: the current estimate (small drift) and feature matches alone (any
// drift). Both are refined by ICP; of two results that agree one is kept. Where the shared surface does not
// determine a motion (one wall, a corridor), what the estimate said of it stays, and the loop's information
// says that it claims nothing there; matches alone would say anything, and are not believed. A pair is tried
// from the estimate again once a correction has changed that by more than ICP would have bridged.
//
// Capacity: max_fragments descriptors, carved from the arena; further fragments are refused and counted.
// Thread: back. Working buffers grow to the size of the largest fragment and are reused.
#pragma once
#include <atomic>
#include <cstdint>
#include <vector>

#include "core/base/arena.hpp"
#include "core/fragment/fragment.hpp"
#include "core/proposal/fpfh.hpp"
#include "core/proposal/global_registration.hpp"
#include "core/proposal/icp.hpp"
#include "core/proposal/loop.hpp"
#include "core/proposal/tried_pairs.hpp"

namespace loopsift {

struct ProposalOptions {
  RegistrationCloudOptions cloud;
  FpfhOptions features;
  GlobalRegistrationOptions global;
  IcpOptions icp;
  int max_fragments = 360;
  int max_registrations_per_fragment = 32;  ///< pairs tried when a fragment closes; bounds the time it takes
  int max_repeats_per_fragment = 4;    ///< earlier pairs tried again then, because their estimate has changed
  int max_matches = 1024;              ///< feature matches of a pair
  float min_overlap = 0.2F;            ///< of the smaller fragment's points, to be a proposal at all
  float min_expected_overlap = 0.05F;  ///< below it the current estimate is not tried as a start
  float same_translation_m = 0.03F;    ///< two results nearer than this …
  float same_rotation_rad = 0.03F;     ///< … and this are one proposal: the registration's accuracy
};
/// Names the first option out of its range.
[[nodiscard]] Status validate(const ProposalOptions& options);

/// Whether two results for one pair are one proposal.
[[nodiscard]] bool same_motion(const Se3& a, const Se3& b, const ProposalOptions& options);

/// Since construction.
struct ProposalCounts {
  std::int64_t pairs_tried = 0;
  std::int64_t pairs_skipped = 0;    ///< beyond max_registrations_per_fragment
  std::int64_t estimates_tried = 0;  ///< pairs registered from the current estimate too
  std::int64_t pairs_repeated = 0;
  std::int64_t proposed = 0;
  std::int64_t fragments = 0;
  std::int64_t refused_fragments = 0;
};

class Proposer {
 public:
  /// `options` must be valid.
  Proposer(const ProposalOptions& options, Arena& arena);
  Proposer(const Proposer&) = delete;
  Proposer& operator=(const Proposer&) = delete;

  /// Computes the fragment's descriptors. Fragments come in order of id, and they and their surfels must
  /// outlive this object. False when the store is full or the order is broken.
  bool add_fragment(const Fragment& fragment);

  /// Tries `newest` (added before) against earlier fragments with |i − j| ≥ 2 and appends what fits, pairs in
  /// order of i. T_map_fragment: the current estimate by fragment index; a fragment beyond its end has none.
  /// drift_m: how well a fragment's position relative to the newest one's is known (standard deviation), by
  /// fragment index; beyond its end, exactly. Loops get consecutive ids, i < j, and T_i_j maps fragment j
  /// into i.
  void propose(FragmentId newest, Span<const Se3> T_map_fragment, Span<const float> drift_m,
               std::vector<Loop>* out);
  /// Tries pairs of earlier fragments that the present estimate brings together, and the one that they were
  /// last tried with did not. At most max_repeats_per_fragment, the nearest first; what is left comes with
  /// the next call.
  void propose_again(Span<const Se3> T_map_fragment, std::vector<Loop>* out);

  /// Once *stop is set (null: never) both leave the pairs not tried yet.
  void stop_on(const std::atomic<bool>* stop) { stop_ = stop; }

  [[nodiscard]] const ProposalCounts& counts() const { return counts_; }

 private:
  static constexpr int kSamples = 128;  ///< points that stand for a fragment where only overlap is guessed
  struct Entry {
    const Fragment* fragment = nullptr;
    Span<std::uint16_t> keypoints;                     ///< indices into the fragment's thinned cloud
    Span<std::uint8_t> features;                       ///< kFpfhSize per keypoint, 1/255 units
    Span<Eigen::Vector3f> samples;                     ///< of the thinned cloud, spread evenly
    Fpfh mean = {};                                    ///< describes the whole fragment
    Eigen::Vector3f center = Eigen::Vector3f::Zero();  ///< of the samples, fragment frame
    float radius = 0;                                  ///< of the samples about it
  };
  struct Candidate {
    std::size_t entry = 0;
    float expected_overlap = 0;     ///< under the current estimate
    float descriptor_distance = 0;  ///< between the fragments' mean features
  };

  struct Repeat {
    std::size_t entry = 0, target = 0;  ///< entry < target
    float apart = 0;                    ///< distance of the centres, in units of both radii
  };

  [[nodiscard]] bool stopped() const { return stop_ != nullptr && *stop_; }
  [[nodiscard]] const Entry* find(FragmentId id) const;
  [[nodiscard]] bool are_neighbours(std::size_t entry, std::size_t later) const;
  [[nodiscard]] float expected_overlap(const Entry& entry, const Se3& T_target_entry, float drift_m) const;
  void choose_repeats(Span<const Se3> T_map_fragment);
  void store(const Fragment& fragment);
  static void load_features(const Entry& entry, std::vector<Fpfh>* features);
  void prepare_target(const Entry& newest);
  void choose_candidates(const Entry& newest, Span<const Se3> T_map_fragment, Span<const float> drift_m);
  void try_pair(const Candidate& candidate, const Entry& newest, Span<const Se3> T_map_fragment,
                std::vector<Loop>* out);
  void find_motions(const Entry& newest, const Entry& earlier);
  void keep(const IcpResult& result, bool good_enough, FragmentId earlier, FragmentId newest,
            std::size_t first_of_pair, std::vector<Loop>* out);

  ProposalOptions options_;
  const std::atomic<bool>* stop_ = nullptr;
  Span<std::uint16_t> keypoint_store_;
  Span<std::uint8_t> feature_store_;
  Span<Eigen::Vector3f> sample_store_;
  TriedPairs tried_;
  std::vector<Entry> entries_;
  ProposalCounts counts_;

  VoxelThinner thinner_;
  FpfhExtractor extractor_;
  FeatureMatcher matcher_;
  GlobalRegistration global_;
  NearestField field_;
  RegistrationCloud target_cloud_, source_cloud_;
  RegistrationCloud target_matched_, source_matched_;  ///< ends of the matches
  Keypoints keypoints_;
  std::vector<Fpfh> features_;
  std::vector<Match> matches_;
  std::vector<MotionHypothesis> hypotheses_;
  std::vector<Candidate> candidates_;
  std::vector<Repeat> repeats_;
};

}  // namespace loopsift
