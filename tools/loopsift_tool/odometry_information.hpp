// SPDX-License-Identifier: MIT
// What is known about how well an odometry measured its motions. In: a redwood .info with records `k k+1 n`
// for the motion from frame k to k+1, or the odometry edges of a .g2o (a run's posegraph.g2o: edges between
// keyframes, with their times beside it). Out: the information of the motion between two frames. Desk code:
// allocates when read.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"

namespace loopsift::tool {

/// A frame by its number in the recording and its time stamp.
struct FramePlace {
  int number = -1;
  double time_s = 0;
};

class OdometryInformation {
 public:
  /// Nothing is known.
  OdometryInformation() = default;
  /// `trajectory` is the odometry that it belongs to. Errors name file and record: a record of other frames,
  /// a matrix that is not positive definite, a graph with times for a trajectory that has none.
  [[nodiscard]] static Expected<OdometryInformation> read(const std::string& path,
                                                          const Trajectory& trajectory);

  /// Of the motion from one frame to a later one ((t, ω), right perturbation), where an edge spans it. A
  /// motion has the share of its edge's covariance that it has of the edge's duration, carried from the
  /// edge's end to its own by the adjoint: the motions along an edge, composed, have exactly the edge's
  /// information. False where nothing is known.
  [[nodiscard]] bool between(const FramePlace& from, const FramePlace& to, Matrix6d* information) const;

 private:
  struct Interval {
    double begin = 0, end = 0;  // seconds, or frame numbers
    Se3 T_odom_end;             // of the frame at the end; used where a motion may end before it
    Matrix6d information = Matrix6d::Zero();
  };
  [[nodiscard]] Status read_info_file(const std::string& path);
  [[nodiscard]] Status read_graph(const std::string& path, const Trajectory& trajectory);
  [[nodiscard]] Status add(const std::string& at, const Interval& span);

  Trajectory trajectory_;        // where spans are longer than a motion
  std::vector<Interval> spans_;  // ascending
  bool by_time_ = false;
};

}  // namespace loopsift::tool
