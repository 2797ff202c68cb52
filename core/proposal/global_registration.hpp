// SPDX-License-Identifier: MIT
// Registration without a start: rigid motions that many feature matches agree on.
//
// Second-order spatial compatibility (Chen et al., SC²-PCR, CVPR 2022): two matches are compatible when the
// distance (and the angle between normals) of their ends is the same in both clouds; the second-order score
// of two compatible matches is the number of matches compatible with both. False matches are compatible by
// chance, but rarely share a crowd. Every seed match proposes the motion of its best-scoring companions.
// Against random sampling or tuple tests (Zhou et al. 2016) this needs no random numbers and no restarts.
//
// In: matches between two clouds. Out: a few distinct motions, best first. Thread: back. Buffers are reused.
#pragma once
#include <cstdint>
#include <vector>

#include "core/geometry/se3.hpp"
#include "core/proposal/fpfh.hpp"

namespace loopsift {

struct GlobalRegistrationOptions {
  float distance_tolerance_m = 0.10F;    ///< of compatible lengths, and of a match that agrees with a motion
  float normal_tolerance_rad = 0.5F;     ///< of compatible angles between normals
  float min_length_m = 0.20F;            ///< pairs of matches closer than this say nothing
  int max_seeds = 128;                   ///< matches tried, those with the most companions
  int companions = 10;                   ///< matches that a seed's motion is fitted to
  int min_agreeing = 8;                  ///< matches that must agree with a motion
  int max_hypotheses = 4;                ///< motions handed back
  float distinct_translation_m = 0.20F;  ///< motions nearer than this …
  float distinct_rotation_rad = 0.15F;   ///< … and this are one
};

/// A motion and the number of matches that agree with it.
struct MotionHypothesis {
  Se3 T_target_source;
  int agreeing = 0;
};

class GlobalRegistration {
 public:
  explicit GlobalRegistration(const GlobalRegistrationOptions& options) : options_(options) {}

  /// Ends of the matches: target[k] and source[k] belong together. Hypotheses best first; none when the
  /// matches do not agree on anything.
  void run(const RegistrationCloud& target, const RegistrationCloud& source,
           std::vector<MotionHypothesis>* hypotheses);

 private:
  void build_compatibility(const RegistrationCloud& target, const RegistrationCloud& source);
  void choose_seeds();
  void gather_companions(std::size_t seed);
  [[nodiscard]] bool fit_companions(const RegistrationCloud& target, const RegistrationCloud& source,
                                    Se3* T) const;
  /// Fits again to all matches that agree, and counts them.
  [[nodiscard]] int refit(const RegistrationCloud& target, const RegistrationCloud& source, Se3* T);
  void insert(const MotionHypothesis& hypothesis, std::vector<MotionHypothesis>* hypotheses) const;
  [[nodiscard]] int common(std::size_t a, std::size_t b) const;

  struct Scored {
    int score = 0;
    std::uint32_t match = 0;
  };
  GlobalRegistrationOptions options_;
  std::size_t count_ = 0;
  std::size_t words_ = 0;            ///< 64-bit words per row
  std::vector<std::uint64_t> rows_;  ///< compatibility, one row of bits per match
  std::vector<Scored> seeds_;
  std::vector<Scored> companions_;
  std::vector<std::uint32_t> agreeing_;
};

/// The rigid motion that brings source points to target points with the least squared error (Umeyama 1991,
/// without scale). `pick` selects the pairs. False for fewer than three or collinear points.
[[nodiscard]] bool fit_rigid(Span<const Eigen::Vector3f> target, Span<const Eigen::Vector3f> source,
                             Span<const std::uint32_t> pick, Se3* T_target_source);

}  // namespace loopsift
