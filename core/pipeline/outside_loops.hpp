// SPDX-License-Identifier: MIT
// Loops of other detectors, who know moments and not fragments.
// In: the motion between two moments of the camera. Out: loops between the fragments that hold the two, as
// soon as both are closed: with F the first camera of a fragment and c the camera of the moment,
// T_Fi_Fj = T_Fi_ci · T_ci_cj · T_Fj_cj⁻¹, its covariance carried along by the adjoint of T_Fj_cj. Capacity:
// kWaiting loops whose fragments are not closed yet; the oldest makes room. Thread: back. Allocates.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/span.hpp"
#include "core/fragment/fragment.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift {

/// As somebody says it.
struct OutsideLoop {
  std::int64_t timestamp_i_ns = 0;  ///< of a depth image
  std::int64_t timestamp_j_ns = 0;
  Se3 T_i_j;                               ///< maps the camera at j to that at i
  Matrix6d covariance = Matrix6d::Zero();  ///< of log(T̂_i_j⁻¹ T_i_j), (t, ω); positive definite
};

class OutsideLoops {
 public:
  static constexpr std::size_t kWaiting = 64;
  static constexpr std::int64_t kSameMoment_ns = 20'000'000;  ///< from a frame that was kept

  void add(const OutsideLoop& loop);
  /// Those whose fragments are among the first `fragments` by now; their ids are for BackEnd::add_loops.
  [[nodiscard]] std::vector<Loop> resolve(Span<const Fragment> fragments);
  /// Left out: a moment between or before the frames of the map, both moments in one fragment, no room.
  [[nodiscard]] std::int64_t left_out() const { return left_out_; }

 private:
  std::vector<OutsideLoop> waiting_;
  std::int64_t left_out_ = 0;
};

}  // namespace loopsift
