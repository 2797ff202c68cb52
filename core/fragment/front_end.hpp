// SPDX-License-Identifier: MIT
// The front thread's whole work on one frame: preprocess → track → fuse → close.
// In: RawFrame. Out: pose, and a fragment whenever one closes. Capacity: fixed by the options; a full store
// means that no further fragment closes while tracking goes on. Thread: front. No allocation after
// construction.
#pragma once
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/fragment/fragment_builder.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/fragment/model_renderer.hpp"
#include "core/frame/frame.hpp"
#include "core/odometry/depth_calibration.hpp"
#include "core/odometry/odometry.hpp"
#include "core/odometry/rotation_alignment.hpp"

namespace loopsift {

struct FrontEndOptions {
  FrameOptions frame;
  OdometryOptions odometry;
  FragmentOptions fragment;
  ModelOptions model;
  DepthCalibrationOptions depth_calibration;
  int lost_patience_frames = 5;  ///< frames that may fail to track before a new piece of trajectory starts
};
[[nodiscard]] Status validate(const FrontEndOptions& options);

/// What one frame took, nanoseconds of the steady clock.
struct FrontEndTimes {
  std::int64_t preprocess_ns = 0;
  std::int64_t odometry_ns = 0;  ///< rendering the model and tracking
  std::int64_t fusion_ns = 0;    ///< with closing, where a fragment closed
};

struct FrontEndResult {
  FrameId frame;
  std::int64_t timestamp_ns = 0;
  TrackingResult tracking;
  const Fragment* closed = nullptr;  ///< the fragment that this frame completed, or that a loss ended
  FrontEndTimes times;
};

class FrontEnd {
 public:
  /// camera and depth_unit_m are those of the raw depth images. The store must outlive this.
  FrontEnd(const PinholeCamera& camera, double depth_unit_m, const FrontEndOptions& options,
           FragmentStore* store, Arena& arena);
  /// Tracks with the built-in odometry. A source that was opened anew (RawFrame::session) starts a new piece
  /// of trajectory: nobody saw where the camera went.
  FrontEndResult process(const RawFrame& raw);
  /// Takes the pose from elsewhere (a file, a message).
  FrontEndResult process(const RawFrame& raw, const TrackingResult& given);
  /// Closes the active fragment at the end of a run; null when there is none or the store is full.
  const Fragment* finish() { return builder_.close(store_); }
  /// The camera's smooth depth error as far as it is known.
  [[nodiscard]] const DisparityCoefficients& disparity() const { return depth_calibration_.coefficients(); }
  [[nodiscard]] const FragmentBuilder& builder() const { return builder_; }

 private:
  TrackingResult track(const Frame& frame, std::int32_t session);
  void keep_keyframe(const Frame& frame, const TrackingResult& tracking);
  FrontEndResult integrate(const Frame& frame, const TrackingResult& tracking);

  FrontEndOptions options_;
  FragmentStore* store_;
  FramePreprocessor preprocessor_;
  Odometry odometry_;
  FragmentBuilder builder_;
  ModelRenderer renderer_;
  Keyframe keyframe_;
  RotationAlignment turns_;
  DepthCalibration depth_calibration_;
  std::size_t piece_begin_ = 0;  // first fragment of the current piece of trajectory
  std::int64_t newest_timestamp_ns_ = 0;
  int lost_frames_ = 0;
  std::int32_t session_ = 0;  // RawFrame::session of the present piece
};

}  // namespace loopsift
