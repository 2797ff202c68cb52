// SPDX-License-Identifier: MIT
// Coarse-to-fine Gauss–Newton on one frame's pose: geometry against the model view, intensities against a
// keyframe and the motion model, in one system. Lives on the stack of Odometry::track. Never allocates.
#pragma once
#include "core/odometry/icp.hpp"
#include "core/odometry/odometry.hpp"
#include "core/odometry/photometric.hpp"

namespace loopsift {

/// The prior's information about a motion that took some frame periods.
[[nodiscard]] Matrix6d prior_information(const OdometryOptions& options, double periods);

class Alignment {
 public:
  /// periods: the time since the last frame in frame periods, 1 or more; the prediction is worth less after a
  /// gap, and partners are looked for farther away. keyframe is null where intensities are not used.
  Alignment(const OdometryOptions& options, const Frame& frame, const ModelView& model,
            const Se3& T_odom_predicted, double periods, const Keyframe* keyframe);
  /// Lets run() start from another pose than the predicted one if that is the likelier.
  void consider(const Se3& T_odom_other);
  void run();
  /// Geometry at the last pose.
  [[nodiscard]] const IcpSystem& system() const { return system_; }
  [[nodiscard]] const Matrix6d& prior() const { return prior_; }
  /// Information of geometry and intensities together, right perturbation, thinned by the pixels that err
  /// together.
  [[nodiscard]] Matrix6d measured() const { return geometric_.H + photometric_.H; }
  /// Of the motion from a pose, the prior included: honest over the sums of tens of frames that a pose graph
  /// holds. What a smooth error of the depths, or colour not registered to them, does to a pose stays as it
  /// is while the view stays, so that its variance grows with the share of the view that changes and with the
  /// error that the least known part of the model may have in it; beyond the noise of single pixels,
  /// residuals are alike all over the image, so that their scale counts for more than the pixels' sum says.
  [[nodiscard]] Matrix6d information_since(const Se3& T_odom_before) const;
  [[nodiscard]] int iterations() const { return iterations_; }
  [[nodiscard]] Se3 T_odom_camera() const { return model_.T_odom_view * T_view_camera_; }
  [[nodiscard]] Vector6d from_prediction() const {
    return (T_view_predicted_.inverse() * T_view_camera_).log();
  }
  /// Part of the keyframe's points that the frame shows; 0 where intensities had no say.
  [[nodiscard]] float keyframe_overlap() const { return overlap_; }

 private:
  // Thinned, right perturbation in the camera frame.
  struct Term {
    Matrix6d H = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
  };
  void linearize_at(int level);
  // Negative log-likelihood of a pose by the coarsest level, intensities and the prior together.
  [[nodiscard]] double cost(const Se3& T_view_camera) const;
  [[nodiscard]] float share_of(const Keyframe::Level& key) const;
  void add_geometry(int level);
  void add_intensities(int level);
  // One Gauss–Newton step; true once it is negligible.
  bool step(int level);
  [[nodiscard]] IcpSettings settings(int level) const;

  const OdometryOptions& options_;
  const Frame& frame_;
  const ModelView& model_;
  const Keyframe* keyframe_;
  int finest_;
  double periods_;
  Matrix6d prior_;
  Se3 T_view_predicted_, T_view_camera_;
  IcpSystem system_;
  Term geometric_, photometric_;
  Matrix6d intensities_ = Matrix6d::Zero();  // photometric_.H before it was bounded
  float scale_ = 2.0F;
  float photometric_scale_ = 0.1F, exposure_ = 0.0F, overlap_ = 0.0F;
  int iterations_ = 0;
};

}  // namespace loopsift
