// SPDX-License-Identifier: MIT
// A loop: a proposed relative transform between two fragments. True or not is for the sifter to find out.
#pragma once
#include <string>
#include <vector>

#include "core/base/ids.hpp"
#include "core/base/result.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

struct Loop {
  LoopId id;
  FragmentId i, j;                              ///< i < j
  Se3 T_i_j;                                    ///< maps fragment j into fragment i
  Matrix6d information = Matrix6d::Identity();  ///< of log(T̂_i_j⁻¹ T_i_j), (t, ω) order; Choi et al. 2015
  float overlap = 0;                            ///< fraction of surfels with a partner; 0 when from outside
  float residual_m = 0;  ///< RMS point-to-plane residual of the partners; 0 when from outside
};

/// Loops from redwood files: records `i j n`, T maps j into i. info_path may be empty (identity scaled as 1
/// cm, 0.5°). Errors name file and record: a fragment ≥ fragment_count, i = j, a transform that is no rigid
/// motion.
[[nodiscard]] Expected<std::vector<Loop>> read_loops(const std::string& log_path,
                                                     const std::string& info_path, int fragment_count);
/// Writes PATH.log and PATH.info (path without ending).
[[nodiscard]] Status write_loops(const std::string& path, const std::vector<Loop>& loops, int fragment_count);

}  // namespace loopsift
