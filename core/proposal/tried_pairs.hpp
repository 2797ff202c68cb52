// SPDX-License-Identifier: MIT
// From which estimate each pair of fragments was last registered, so that it is registered again only when
// the estimate has changed. Capacity: all pairs of max_fragments. Thread: back. Never allocates.
#pragma once
#include <cstddef>

#include "core/base/arena.hpp"
#include "core/base/span.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

class TriedPairs {
 public:
  TriedPairs(int max_fragments, Arena& arena);
  /// Pair i < j was registered from this estimate.
  void set(std::size_t i, std::size_t j, const Se3& T_j_i);
  /// How far, at most, a point of fragment i within `radius` of `center` (frame i) has moved in fragment j
  /// since then, metres. Infinite where the pair was never tried.
  [[nodiscard]] float moved(std::size_t i, std::size_t j, const Se3& T_j_i, const Eigen::Vector3f& center,
                            float radius) const;

 private:
  struct Motion {
    float q[4];  // x y z w; all 0: never tried
    float t[3];
  };
  [[nodiscard]] Motion& at(std::size_t i, std::size_t j) const { return motions_[j * (j - 1) / 2 + i]; }

  Span<Motion> motions_;
};

}  // namespace loopsift
