// SPDX-License-Identifier: MIT
// How each filter holds up when more of the loops are false, and when the scale of the loops' or of the
// odometry's information is wrong: that nobody knows these scales is why filters with parameters are not
// trusted. Desk code: allocates, all cores, the same for the same seeds (but for times).
#pragma once
#include <string>
#include <vector>

#include "tools/loopsift_tool/comparison/contest.hpp"

namespace loopsift::tool {

struct SweepOptions {
  /// False loops that are added, by the number of true ones among the given.
  std::vector<double> false_shares = {0.0, 0.25, 0.5, 0.75, 1.0};
  /// Of the information, with the last of false_shares.
  std::vector<double> factors = {0.1, 0.32, 1.0, 3.2, 10.0};
  int seeds = 3;  ///< 1, 2, … of the false loops
};
[[nodiscard]] Status validate(const SweepOptions& options);

/// One filter at one point.
struct SweepRow {
  const char* axis = "";  ///< "false_loops", "loop_information", "odometry_information"
  double value = 0;       ///< on that axis
  int seed = 0;
  std::string filter;
  std::size_t loops = 0, true_loops = 0;
  Figures figures;
  double wall_s = 0;
  std::string failure;
};

/// Runs every contestant at every point. `input` is the comparison as it was given, at odometry_factor 1.
[[nodiscard]] Expected<std::vector<SweepRow>> run_sweep(const ContestInput& input, const Truth& truth,
                                                        const SweepOptions& options);
/// One line a row, what is absent left empty.
[[nodiscard]] Status write_sweep_csv(const std::string& path, const std::vector<SweepRow>& rows);

}  // namespace loopsift::tool
