// SPDX-License-Identifier: MIT
// What is known about a recording's true poses and loops. In: a true trajectory, labelled pairs of fragments,
// or both. Out: the true pose of a frame, and which loops are true. Desk code: allocates.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/fragment/fragment.hpp"
#include "core/geometry/trajectory.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift::tool {

struct TruthFiles {
  std::string trajectory;             ///< TUM or redwood .log; may be empty
  std::string loops_log, loops_info;  ///< redwood files of labelled pairs; may be empty
};

class Truth {
 public:
  /// Errors: neither a trajectory nor labels, labels without information, files that cannot be read.
  [[nodiscard]] static Expected<Truth> read(const TruthFiles& files);

  [[nodiscard]] bool has_trajectory() const { return trajectory_.has_value(); }
  /// False where the trajectory has no pose for the frame.
  [[nodiscard]] bool pose(const FragmentFrame& frame, Se3* T_gt_camera) const;
  /// T_i_j between the first cameras of two fragments, by the trajectory. Error: no pose for one of them.
  [[nodiscard]] Expected<Se3> motion(Span<const Fragment> fragments, FragmentId i, FragmentId j) const;

  /// Ids of the true loops. By the labels where there are any: the pair is labelled and ξᵀ Λ ξ / Λ₁₁ ≤ 0.04
  /// m² (Choi et al. 2015). Else by the trajectory: within kTrueWithin_m and kTrueWithin_rad of the motion.
  [[nodiscard]] Expected<std::set<int>> true_loops(const std::vector<Loop>& loops,
                                                   Span<const Fragment> fragments) const;
  static constexpr double kTrueWithin_m = 0.10;
  static constexpr double kTrueWithin_rad = 5.0 * 3.14159265358979 / 180.0;

 private:
  struct Label {
    Se3 T_i_j;
    Matrix6d information;
  };
  [[nodiscard]] Status read_labels(const TruthFiles& files);
  [[nodiscard]] bool is_labelled(const Loop& loop) const;

  std::optional<Trajectory> trajectory_;
  std::optional<std::map<std::pair<int, int>, Label>> labels_;
};

}  // namespace loopsift::tool
