// SPDX-License-Identifier: MIT
// Fast point feature histograms (Rusu, Blodow, Beetz 2009), and their mutual nearest neighbours.
// In: a thinned cloud. Out: a descriptor for each of its most distinctive points. Invariant under rigid
// motion. Thread: back. Buffers are reused.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/proposal/point_grid.hpp"
#include "core/proposal/registration_cloud.hpp"

namespace loopsift {

/// Three histograms (α, φ, θ) of 11 bins each, each summing to 1, then the square root of every bin: the
/// Euclidean distance of two such is the Hellinger distance of the histograms.
constexpr int kFpfhBins = 11;
constexpr int kFpfhSize = 3 * kFpfhBins;
using Fpfh = std::array<float, kFpfhSize>;

struct FpfhOptions {
  float radius_m = 0.30F;    ///< neighbourhood; about six voxels of the cloud
  int min_neighbours = 8;    ///< points with fewer get no descriptor
  int max_keypoints = 1024;  ///< the points whose descriptors differ most from the cloud's mean are kept
};

/// Points with descriptors. `points` are indices into the cloud, ascending; both of the same size.
struct Keypoints {
  std::vector<std::uint16_t> points;
  std::vector<Fpfh> features;
  Fpfh mean = {};  ///< over all described points of the cloud: a descriptor of the whole
  [[nodiscard]] std::size_t size() const { return points.size(); }
};

class FpfhExtractor {
 public:
  explicit FpfhExtractor(const FpfhOptions& options) : options_(options) {}
  void extract(const RegistrationCloud& cloud, Keypoints* keypoints);

 private:
  template <class F>
  void for_each_neighbour(const RegistrationCloud& cloud, std::size_t point, F f) const;
  void accumulate_simplified(const RegistrationCloud& cloud);
  [[nodiscard]] Fpfh weighted(const RegistrationCloud& cloud, std::size_t point) const;
  void keep_distinctive(Keypoints* keypoints);

  FpfhOptions options_;
  RadiusIndex index_;
  std::vector<int> neighbour_counts_;
  std::vector<Fpfh> simplified_;  ///< SPFH: bin counts of each point's own pairs
  std::vector<float> distinctiveness_;
  std::vector<std::size_t> order_;
};

/// Two keypoints (indices into the two lists) that are each other's nearest in feature space.
struct Match {
  std::uint16_t target = 0, source = 0;
  float squared_distance = 0;
};

/// Mutual nearest neighbours by brute force: at 33 dimensions no tree is quicker. Keeps the target's features
/// transposed, so that one target serves many sources.
class FeatureMatcher {
 public:
  static constexpr std::size_t kLanes = 32;  ///< targets that are compared at once

  void set_target(Span<const Fpfh> features);
  /// Best match first; at most max_matches.
  void match(Span<const Fpfh> source, int max_matches, std::vector<Match>* matches);

 private:
  struct Block {
    float features[kFpfhSize][kLanes];
    float squared_norms[kLanes];
  };
  struct Best {
    float distances[kLanes];
    std::int32_t indices[kLanes];
  };
  static void compare(const Fpfh& source, float squared_norm, std::int32_t source_index, const Block& block,
                      std::int32_t block_index, Best* of_source, Best* of_targets);

  std::size_t target_count_ = 0;
  std::vector<Block> blocks_;
  std::vector<Best> best_of_targets_;
  std::vector<Match> best_of_sources_;
};

}  // namespace loopsift
