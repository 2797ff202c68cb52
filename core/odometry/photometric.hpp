// SPDX-License-Identifier: MIT
// One linearisation of direct image alignment: every pixel of a keyframe level, with its depth, against the
// intensities of the present frame (Steinbrücker et al. 2011; Kerl et al., Robust odometry estimation for
// RGB-D cameras, 2013). For a keyframe point q seen at pixel π(q) of the present camera, q = T_camera_key p:
// r = I(π(q)) − I_key − e, with e the common change of (log) exposure, which is estimated along and
// eliminated. For T_key_camera ← T_key_camera exp(ξ): ∂r/∂ξ = −[gᵀ, (q × g)ᵀ], g = ∇I ∂π/∂q. Weights:
// Student's t with 5 degrees of freedom over the residuals' own scale. Thread: any. Never allocates;
// vectorised with run-time dispatch.
#pragma once
#include "core/frame/frame.hpp"
#include "core/geometry/se3.hpp"
#include "core/odometry/keyframe.hpp"

namespace loopsift {

struct PhotometricSettings {
  float depth_gate_m =
      0.05F;           ///< a point farther than this (plus 3 %) behind or before what is measured is hidden
  float scale = 0.1F;  ///< of the residuals, log intensity
  float exposure = 0.0F;  ///< e of the last linearisation
};

struct PhotometricSystem {
  Matrix6d H = Matrix6d::Zero();  ///< JᵀWJ, right perturbation in the camera's frame, exposure eliminated
  Vector6d b = Vector6d::Zero();  ///< JᵀW r, the same
  float scale = 0;                ///< the next scale
  float exposure = 0;             ///< the next e
  double weight = 0;              ///< Σ of the robust weights (each 0 … 1.2)
  int inside = 0;                 ///< keyframe points that fall into the image
  int seen = 0;                   ///< keyframe points that the frame shows
};

[[nodiscard]] PhotometricSystem linearize_photometric(const FrameLevel& level, const Keyframe::Level& key,
                                                      const Se3& T_camera_key,
                                                      const PhotometricSettings& settings);

}  // namespace loopsift
