// SPDX-License-Identifier: MIT
// Frame-to-model tracking: projective point-to-plane ICP (Newcombe et al., KinectFusion, 2011; Keller et al.,
// Point-based fusion, 2013) and direct alignment of intensities with a keyframe (Kerl et al. 2013), coarse to
// fine, in one Gauss–Newton system with a constant-velocity prior.
// In: Frame, a ModelView rendered by the caller at predict(), and a Keyframe where there is colour. Out:
// TrackingResult. Minimises Σ ρ(r_i / (s σ(z_i))) + Σ ρ(c_j / s_c) + ‖log(T_pred⁻¹ T)‖²_Λ with r_i = n_i · (T
// p_i − q_i), c_j differences of log intensity, σ(z) the sensor's noise, s and s_c the residuals' own scales.
// Thread: front. No allocation after construction.
#pragma once
#include <cstdint>

#include "core/base/result.hpp"
#include "core/frame/frame.hpp"
#include "core/geometry/se3.hpp"
#include "core/odometry/keyframe.hpp"

namespace loopsift {

struct OdometryOptions {
  int finest_level = 0;       ///< pyramid level of the last iterations; the last of the frame if it has fewer
  int iterations_coarse = 6;  ///< at most, on every level but the finest
  int iterations_fine = 6;    ///< at most, on the finest level
  float gate_coarse_m = 0.15F;     ///< partners farther apart are none, on the coarsest level
  float gate_fine_m = 0.05F;       ///< the same on the finest
  float min_normal_cosine = 0.5F;  ///< partners' normals differ by at most acos of this
  float noise_floor_m = 0.0012F;  ///< σ(z) = floor + slope · (z − 0.4 m)², the form of Nguyen et al. 2012;
                                  ///< slope also for distortion
  float noise_slope = 0.003F;            ///< per metre
  float prior_sigma_m = 0.03F;           ///< of the constant-velocity prediction, per 1/30 s
  float prior_sigma_rad = 0.03F;         ///< the same for rotation
  float correlated_pixels = 300.0F;      ///< pixels that err together; divides the information
  bool photometric = true;               ///< track intensities, too, where there is colour
  float photometric_floor_m = 0.01F;     ///< what they say about the motion is never more certain than this:
                                         ///< they decide where the geometry slides, and harm nowhere else
  float photometric_floor_rad = 0.007F;  ///< the same for rotation
  float min_inlier_fraction = 0.2F;      ///< of the pixels with depth; below it tracking is lost
  float max_step_m = 0.5F;               ///< from the prediction; a larger motion is no motion: lost
  float max_step_rad = 0.6F;             ///< the same for rotation
};
[[nodiscard]] Status validate(const OdometryOptions& options);

enum class TrackingStatus {
  kFirst,    ///< first frame, or first after a loss: the pose starts a new piece of trajectory
  kTracked,  ///< pose and information hold
  kLost,     ///< no pose; reason says why
};

enum class LostReason {
  kNone,
  kNoDepth,      ///< too few pixels with depth
  kNoModel,      ///< the model is out of sight
  kFewInliers,   ///< too few pixels agree with the model
  kLargeMotion,  ///< the solution is too far from the prediction
  kNoPose,       ///< external odometry has no pose for this time
  kBadTime,      ///< the frame's time stamp is not after the one before
};
/// For a person: "too little depth", … Never null.
[[nodiscard]] const char* to_string(LostReason reason);

struct TrackingResult {
  TrackingStatus status = TrackingStatus::kLost;
  LostReason reason = LostReason::kNone;
  Se3 T_odom_camera;                        ///< the last known pose when lost
  Matrix6d information = Matrix6d::Zero();  ///< of log(T̂⁻¹ T) ((t, ω), right perturbation): of the motion
                                            ///< since the frame before; zero when unknown
  float inlier_fraction = 0;   ///< of the pixels with depth
  float residual_rms_m = 0;    ///< of the inliers
  int iterations = 0;          ///< over all levels
  float keyframe_overlap = 0;  ///< of the keyframe's points, those in sight; 0: colour was not used
  float degeneracy = 0;  ///< share of the prior in the least known direction, 0 … 1; above ½ the geometry
                         ///< says less than the prediction and the scene slides
};

/// The model as seen from a pose: one oriented point per pixel, in the frame of that view. Owns nothing.
struct ModelView {
  PinholeCamera camera;
  Se3 T_odom_view;
  ImageView<const float> x, y, z;     ///< metres, view frame; z = 0: nothing there
  ImageView<const float> nx, ny, nz;  ///< unit normals, view frame
  float disparity_unknown = 1.0F;     ///< Fragment::disparity_unknown of its least known part
};

class Odometry {
 public:
  explicit Odometry(const OdometryOptions& options);
  /// Where the next frame is expected: constant velocity in the camera frame, scaled by the times of the
  /// frames.
  [[nodiscard]] Se3 predict(std::int64_t timestamp_ns) const;
  /// Tracks the frame against the model (and the keyframe, if there is one and the frame has colour) and
  /// takes the result as the new state. Lost leaves the state as it was. T_odom_other: a pose to start from
  /// instead of the predicted one if the frame, on its coarsest level, and the motion model together find it
  /// the likelier of the two; null: none.
  TrackingResult track(const Frame& frame, const ModelView& model, const Keyframe* keyframe = nullptr,
                       const Se3* T_odom_other = nullptr);
  /// Starts a (new) piece of trajectory at the given pose: kFirst, or kLost where the frame shows too little.
  TrackingResult start(const Frame& frame, const Se3& T_odom_camera);
  [[nodiscard]] const Se3& T_odom_camera() const { return T_odom_camera_; }

 private:
  void move_to(const Se3& T_odom_camera, std::int64_t timestamp_ns);
  [[nodiscard]] double periods_to(std::int64_t timestamp_ns) const;

  static constexpr double kPeriodS = 1.0 / 30;    // of the prior's sigmas
  static constexpr double kMaxPeriods = 30;       // a gap longer than that makes the prior no weaker
  static constexpr double kGapPeriods = 6;        // from there on a pose must prove itself
  static constexpr double kMaxPredictionS = 0.5;  // a velocity older than that says nothing
  OdometryOptions options_;
  Se3 T_odom_camera_;
  Vector6d velocity_ = Vector6d::Zero();  // per second, camera frame
  std::int64_t timestamp_ns_ = 0;
  bool moving_ = false;  // velocity_ is known
};

}  // namespace loopsift
