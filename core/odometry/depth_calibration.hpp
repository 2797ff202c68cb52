// SPDX-License-Identifier: MIT
// Finds the camera's smooth depth error while it moves: a surface seen by two frames at different places of
// the image must be the same surface. For a pair of frames, point-to-plane residuals are linear in their
// relative pose and in the error's coefficients c (disparity_correction.hpp), which enter through both
// points: ∂r/∂c = −(n·R d_f) z_f² φ_f + (n·d_k) z_k² φ_k, d the rays at depth 1. The pose is eliminated; what
// is left is summed over pairs, with a prior at no error. After Zeisl & Pollefeys, Structure-based
// auto-calibration of RGB-D sensors (2016), in spirit. In: a keyframe and a later frame with known poses.
// Out: coefficients. Thread: front. Never allocates.
#pragma once
#include "core/base/result.hpp"
#include "core/frame/disparity_correction.hpp"
#include "core/frame/frame.hpp"
#include "core/geometry/se3.hpp"
#include "core/odometry/keyframe.hpp"

namespace loopsift {

struct DepthCalibrationOptions {
  bool enabled = true;
  float sigma_per_m = 0.002F;  ///< of each coefficient before anything was seen, 1/m
  float caution = 6.0F;  ///< errors that pairs have in common do not show in their scatter: it is taken to be
                         ///< this many times larger, as a variance
  float memory = 0.98F;  ///< weight of all that was seen, when a pair comes in
};
[[nodiscard]] Status validate(const DepthCalibrationOptions& options);

class DepthCalibration {
 public:
  explicit DepthCalibration(const DepthCalibrationOptions& options);
  /// Learns from two frames that show the same things; false when too little of them does.
  bool add_pair(const Keyframe& key, const Frame& frame, const Se3& T_odom_frame);
  [[nodiscard]] const DisparityCoefficients& coefficients() const { return coefficients_; }
  /// What is left to learn: the variance of the error, mean of the image, as a share of the prior's; 1 … 0.
  [[nodiscard]] float unknown() const { return unknown_; }

 private:
  using Information = Eigen::Matrix<double, kDisparityTerms, kDisparityTerms>;

  void add(const Information& information, const DisparityCoefficients& gradient);
  // What pairs scatter about the coefficients, in units of their own claim.
  [[nodiscard]] double variance() const;

  DepthCalibrationOptions options_;
  Information information_ = Information::Zero();
  DisparityCoefficients gradient_ = DisparityCoefficients::Zero();  // information · coefficients
  double squares_ = 0, directions_ = 0;  // Σ ĉᵀ H ĉ of the pairs' own estimates, and their number
  DisparityCoefficients coefficients_ = DisparityCoefficients::Zero();
  float unknown_ = 1.0F;
};

}  // namespace loopsift
