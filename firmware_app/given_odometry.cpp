// SPDX-License-Identifier: MIT
#include "firmware_app/given_odometry.hpp"

#include <utility>

#include "core/geometry/body_axes.hpp"
#include "drivers/lcm/lcm_poses.hpp"

namespace loopsift {
namespace {

Se3 mount(const LcmOdometryOptions& o) {
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(o.camera_yaw_rad, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(o.camera_pitch_rad, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(o.camera_roll_rad, Eigen::Vector3d::UnitX());
  return {turned, {o.camera_x_m, o.camera_y_m, o.camera_z_m}};
}

/// The receiver's thread pushes, the front thread tracks.
class LcmOdometry final : public ExternalOdometry {
 public:
  explicit LcmOdometry(const StreamOdometryOptions& options) : stream_(options) {}
  Status open(const std::string& channel, const LcmInOptions& lcm_in, const Se3& T_body_mount) {
    auto poses = LcmPoses::open(channel, lcm_in, [this, T_body_mount](std::int64_t t_ns, const Se3& T) {
      stream_.push(t_ns, camera_pose(T, T_body_mount));
    });
    if (!poses) return poses.error();
    poses_ = std::move(*poses);
    return {};
  }
  TrackingResult track(FrameId frame, std::int64_t timestamp_ns) override {
    return stream_.track(frame, timestamp_ns);
  }
  [[nodiscard]] std::string summary() const override {
    const StreamOdometryCounts& c = stream_.counts();
    return std::to_string(c.taken) + " poses over LCM; left out: " + std::to_string(c.late) +
           " repeated or late, " + std::to_string(poses_->bad()) + " unreadable, " +
           std::to_string(c.refused) + " not taken in time; " + std::to_string(c.jumps) + " jumps, " +
           std::to_string(c.restarts) + " clocks set back, " + std::to_string(c.missing) +
           " frames without a pose";
  }

 private:
  StreamOdometry stream_;
  std::unique_ptr<LcmPoses> poses_;  // ends before the stream
};

}  // namespace

Expected<std::unique_ptr<ExternalOdometry>> open_odometry(const std::string& uri,
                                                          const TrajectoryOdometryOptions& file,
                                                          const LcmOdometryOptions& lcm,
                                                          const LcmInOptions& lcm_in, bool camera_clock) {
  if (uri.rfind("lcm:", 0) == 0) {
    LcmInOptions receiving = lcm_in;
    receiving.host_clock = receiving.host_clock || camera_clock;
    auto odometry = std::make_unique<LcmOdometry>(lcm.stream);
    if (const Status opened = odometry->open(uri.substr(4), receiving, mount(lcm)); !opened)
      return opened.error();
    return std::unique_ptr<ExternalOdometry>(std::move(odometry));
  }
  if (uri.rfind("file:", 0) != 0) return std::unique_ptr<ExternalOdometry>();
  auto trajectory = TrajectoryOdometry::open(uri.substr(5), file);
  if (!trajectory) return trajectory.error();
  return std::unique_ptr<ExternalOdometry>(std::make_unique<TrajectoryOdometry>(std::move(*trajectory)));
}

}  // namespace loopsift
