// SPDX-License-Identifier: MIT
// One linearisation of projective point-to-plane ICP: every pixel of a frame level against the model view.
// For a pixel with point p (camera) and its partner q with normal n (view): r = n · (T p − q); for T ← exp(ξ)
// T, ∂r/∂ξ = [nᵀ, (T p × n)ᵀ]. Weights: 1 / (s σ(z))² times that of Student's t with 5 degrees of freedom
// (Kerl et al. 2013). Thread: any. Never allocates; vectorised with run-time dispatch.
#pragma once
#include "core/geometry/se3.hpp"
#include "core/odometry/odometry.hpp"

namespace loopsift {

struct IcpSettings {
  float gate_m = 0.05F;  ///< partners farther apart are none; widened by 3 σ(z)
  float min_normal_cosine = 0.5F;
  float noise_floor_m = 0.0012F;
  float noise_slope = 0.0019F;
  float scale = 1.0F;  ///< s: residuals' own scale in units of σ(z)
};

struct IcpSystem {
  Matrix6d H = Matrix6d::Zero();  ///< JᵀWJ, left perturbation in the view's frame
  Vector6d b = Vector6d::Zero();  ///< JᵀW r
  /// H with one of its two normals taken from the frame instead of the model: ½ (JᵀWK + KᵀWJ). The noise of
  /// the two is independent, so that it does not add up to information that is not there.
  Matrix6d crossed = Matrix6d::Zero();
  double weight = 0;          ///< Σ of the robust weights (each 0 … 1.2)
  double scaled_squares = 0;  ///< Σ robust weight · (r / σ)²: over partners, the next s²
  double squares_m2 = 0;      ///< Σ r² of the inliers
  int valid = 0;              ///< pixels with depth and normal
  int met = 0;                ///< of them, those that fall on something of the model
  int partners = 0;           ///< of them, those with a partner
  int inliers = 0;            ///< of them, those within 3 s σ
};

[[nodiscard]] IcpSystem linearize(const FrameLevel& level, const ModelView& model, const Se3& T_view_camera,
                                  const IcpSettings& settings);

/// The sensor's depth noise (Nguyen et al. 2012): floor + slope · (z − 0.4 m)².
[[nodiscard]] inline float depth_sigma(float z, float floor_m, float slope) {
  return floor_m + slope * (z - 0.4F) * (z - 0.4F);
}

}  // namespace loopsift
