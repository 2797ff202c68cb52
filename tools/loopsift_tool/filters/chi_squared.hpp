// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>

namespace loopsift::tool {

/// The value below which a χ² variable with so many degrees of freedom stays with a probability of 0.95, by
/// Wilson and Hilferty's cube (The distribution of chi-square, PNAS 1931): within 0.2 % from six degrees on.
[[nodiscard]] inline double chi2_quantile_95(int degrees_of_freedom) {
  constexpr double kNormalQuantile = 1.644854;
  if (degrees_of_freedom <= 0) return 0.0;
  const double k = degrees_of_freedom, spread = 2.0 / (9.0 * k);
  const double root = 1.0 - spread + kNormalQuantile * std::sqrt(spread);
  return k * root * root * root;
}

}  // namespace loopsift::tool
