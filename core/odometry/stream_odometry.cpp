// SPDX-License-Identifier: MIT
#include "core/odometry/stream_odometry.hpp"

#include <algorithm>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kSameTime_ns = 100'000;  // to which senders round
constexpr double kJitter_m = 0.05;              // of poses that follow each other closely

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

void count(std::atomic<std::int64_t>* counter) { counter->fetch_add(1, std::memory_order_relaxed); }

}  // namespace

StreamOdometry::StreamOdometry(const StreamOdometryOptions& options)
    : options_(options), storage_(kWaiting), waiting_(storage_), chain_(options.noise) {}

void StreamOdometry::push(std::int64_t timestamp_ns, const Se3& T_odom_camera) {
  if (!waiting_.try_push({timestamp_ns, T_odom_camera})) return count(&counts_.refused);
  arrived_.post();
}

TrackingResult StreamOdometry::track(FrameId /*frame*/, std::int64_t timestamp_ns) {
  const std::int64_t deadline_ns = steady_now_ns() + static_cast<std::int64_t>(options_.wait_ms * 1e6);
  take_waiting();
  while (size_ == 0 || past(0).timestamp_ns < timestamp_ns - kSameTime_ns) {
    if (!arrived_.wait_until(deadline_ns)) break;
    take_waiting();
  }
  Se3 T_odom_camera;
  if (find(timestamp_ns, &T_odom_camera)) return chain_.found(T_odom_camera);
  count(&counts_.missing);
  return chain_.missing();
}

void StreamOdometry::take_waiting() {
  Pose pose;
  while (waiting_.try_pop(&pose)) take(pose);
}

void StreamOdometry::take(const Pose& pose) {
  if (size_ > 0) {
    const std::int64_t forward_ns = pose.timestamp_ns - past(0).timestamp_ns;
    const double moved_m = (pose.T_odom_camera.translation() - past(0).T_odom_camera.translation()).norm();
    if (forward_ns <= -kSecond_ns) {
      count(&counts_.restarts);
      start_anew();
    } else if (forward_ns <= 0) {
      return count(&counts_.late);
    } else if (moved_m > kJitter_m + options_.max_speed_m_per_s * seconds(forward_ns)) {
      count(&counts_.jumps);
      start_anew();
    }
  }
  history_[taken_++ % kHistory] = pose;
  size_ = std::min(size_ + 1, kHistory);
  count(&counts_.taken);
}

void StreamOdometry::start_anew() {
  size_ = 0;
  chain_.cut();
}

bool StreamOdometry::find(std::int64_t timestamp_ns, Se3* T_odom_camera) const {
  std::size_t before = 0;  // the newest pose that is not after the time
  while (before < size_ && past(before).timestamp_ns > timestamp_ns + kSameTime_ns) ++before;
  if (before == size_) return false;
  const Pose& a = past(before);
  *T_odom_camera = a.T_odom_camera;
  if (timestamp_ns - a.timestamp_ns <= kSameTime_ns) return true;
  if (before == 0) return false;
  const Pose& b = past(before - 1);
  const double gap_s = seconds(b.timestamp_ns - a.timestamp_ns);
  if (gap_s > options_.max_gap_s) return false;
  *T_odom_camera =
      interpolate(a.T_odom_camera, b.T_odom_camera, seconds(timestamp_ns - a.timestamp_ns) / gap_s);
  return true;
}

}  // namespace loopsift
