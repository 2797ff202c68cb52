// SPDX-License-Identifier: MIT
#include "drivers/synth/odometry_drift.hpp"

#include <cmath>
#include <vector>

#include "drivers/synth/random.hpp"

namespace loopsift {
namespace {

constexpr double kTwoPi = 6.283185307179586;
// Disturbances per frame before scaling; only their ratios matter.
constexpr double kNoise_m = 0.0006, kNoise_rad = 0.0003;
constexpr double kBias_m = 0.0004, kBias_rad = 0.00015;

std::vector<Vector6d> disturbances(const Trajectory& truth, std::uint64_t seed) {
  std::vector<Vector6d> all;
  for (std::size_t k = 1; k < truth.poses.size(); ++k) {
    Vector6d xi;
    for (int axis = 0; axis < 6; ++axis) {
      const auto a = static_cast<std::uint64_t>(axis);
      const bool moves = axis < 3;
      xi(axis) = (moves ? kNoise_m : kNoise_rad) *
                 static_cast<double>(gaussian(static_cast<std::uint32_t>(mix(mix(seed, a), k))));
      for (std::uint64_t wave = 0; wave < 3; ++wave) {
        const std::uint64_t bits = mix(mix(seed, 100 + a), wave);
        const double period_s = 5.0 + 20.0 * static_cast<double>(uniform(bits));
        const double phase = kTwoPi * static_cast<double>(uniform(mix(bits, 7)));
        xi(axis) +=
            (moves ? kBias_m : kBias_rad) * std::sin(kTwoPi * truth.poses[k].time_s / period_s + phase);
      }
    }
    all.push_back(xi);
  }
  return all;
}

Trajectory disturbed(const Trajectory& truth, const std::vector<Vector6d>& disturbance, double scale) {
  Trajectory odometry = truth;
  for (std::size_t k = 1; k < truth.poses.size(); ++k) {
    const Se3 motion = truth.poses[k - 1].T_world_camera.inverse() * truth.poses[k].T_world_camera;
    odometry.poses[k].T_world_camera =
        (odometry.poses[k - 1].T_world_camera * motion * Se3::exp(scale * disturbance[k - 1])).normalized();
  }
  return odometry;
}

double end_error(const Trajectory& a, const Trajectory& b) {
  return (a.poses.back().T_world_camera.translation() - b.poses.back().T_world_camera.translation()).norm();
}

}  // namespace

Trajectory drifting_odometry(const Trajectory& truth, double end_error_m, std::uint64_t seed) {
  if (truth.poses.size() < 2) return truth;
  const std::vector<Vector6d> disturbance = disturbances(truth, seed);
  double low = 0, high = 0.01;
  for (int i = 0; i < 20 && end_error(truth, disturbed(truth, disturbance, high)) < end_error_m; ++i) {
    low = high;
    high *= 2.0;
  }
  for (int i = 0; i < 30; ++i) {  // bisection: the error grows with the scale
    const double middle = 0.5 * (low + high);
    (end_error(truth, disturbed(truth, disturbance, middle)) < end_error_m ? low : high) = middle;
  }
  return disturbed(truth, disturbance, high);
}

}  // namespace loopsift
