// SPDX-License-Identifier: MIT
#include "core/odometry/photometric.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"
#include "core/odometry/normal_equations.hpp"

namespace loopsift {
namespace {

constexpr int kColumns = 7;  // six of the motion, one of the exposure
constexpr int kScalars = 5;  // weight, weighted squares, weighted residuals, points inside, points seen
constexpr int kSums = sum_count(kColumns, kScalars);
constexpr int kFirstScalar = kSums - kScalars;
constexpr float kStudentNu = 5.0F;
constexpr double kTiny = 1e-12;

struct Job {
  const float *intensity, *depth;  // of the present frame
  int width, height;
  float fx, fy, cx, cy;
  float inverse_fx, inverse_fy, key_cx, key_cy;
  float R[9], t[3];  // T_camera_key
  float gate, inverse_scale2, exposure;
};

struct Block {
  int count = 0;  // lanes in use, a multiple of kLanes
  alignas(32) float depth[kBlock], intensity[kBlock];
  alignas(32) float x[kBlock], y[kBlock], z[kBlock], u[kBlock], v[kBlock], inside[kBlock];
  alignas(32) std::int32_t corner[kBlock];
  alignas(32) float J[kColumns][kBlock], r[kBlock], w[kBlock], square[kBlock], ok[kBlock];
};

using Sums = float[kSums][kLanes];

// Keyframe points in the present camera, and the image cells that they fall into.
LOOPSIFT_SIMD void project(const Job& j, float x0, float y, Block& __restrict s) {
  const float ray_y = (y - j.key_cy) * j.inverse_fy;
  const float last_u = static_cast<float>(j.width - 1), last_v = static_cast<float>(j.height - 1);
  for (int i = 0; i < s.count; ++i) {
    const float z = s.depth[i];
    const float x = (x0 + static_cast<float>(i) - j.key_cx) * j.inverse_fx * z, yy = ray_y * z;
    const float px = j.R[0] * x + j.R[1] * yy + j.R[2] * z + j.t[0];
    const float py = j.R[3] * x + j.R[4] * yy + j.R[5] * z + j.t[1];
    const float pz = j.R[6] * x + j.R[7] * yy + j.R[8] * z + j.t[2];
    const float inverse_z = 1.0F / std::max(pz, 0.05F);
    const float u = j.fx * px * inverse_z + j.cx, v = j.fy * py * inverse_z + j.cy;
    const bool inside = (z > 0.0F) & (pz > 0.05F) & (u >= 0.0F) & (v >= 0.0F) & (u < last_u) & (v < last_v);
    const float su = inside ? u : 0.0F, sv = inside ? v : 0.0F;
    s.corner[i] = static_cast<std::int32_t>(sv) * j.width + static_cast<std::int32_t>(su);
    s.x[i] = px;
    s.y[i] = py;
    s.z[i] = pz;
    s.u[i] = su - static_cast<float>(static_cast<std::int32_t>(su));
    s.v[i] = sv - static_cast<float>(static_cast<std::int32_t>(sv));
    s.inside[i] = inside ? 1.0F : 0.0F;
  }
}

// Residuals, Jacobians and weights; weight 0 where the frame does not show the point.
LOOPSIFT_SIMD void evaluate(const Job& j, Block& __restrict s) {
  for (int i = 0; i < s.count; ++i) {
    const std::int32_t k = s.corner[i];
    const float a = j.intensity[k], b = j.intensity[k + 1];
    const float c = j.intensity[k + j.width], d = j.intensity[k + j.width + 1];
    const float u = s.u[i], v = s.v[i];
    const std::int32_t nearest = k + (u >= 0.5F ? 1 : 0) + (v >= 0.5F ? j.width : 0);
    const float top = a + u * (b - a), bottom = c + u * (d - c);
    const float gx = (b - a) + v * ((d - c) - (b - a)), gy = bottom - top;
    const float r = top + v * gy - s.intensity[i] - j.exposure;
    const float measured = j.depth[nearest];
    const bool ok =
        (s.inside[i] > 0.0F) & (measured > 0.0F) & (std::fabs(measured - s.z[i]) < j.gate + 0.03F * s.z[i]);
    const float w = ok ? (kStudentNu + 1.0F) / (kStudentNu + r * r * j.inverse_scale2) : 0.0F;
    const float inverse_z = 1.0F / std::max(s.z[i], 0.05F);
    const float g0 = gx * j.fx * inverse_z, g1 = gy * j.fy * inverse_z;
    const float g2 = -(g0 * s.x[i] + g1 * s.y[i]) * inverse_z;
    s.J[0][i] = -g0;
    s.J[1][i] = -g1;
    s.J[2][i] = -g2;
    s.J[3][i] = s.z[i] * g1 - s.y[i] * g2;
    s.J[4][i] = s.x[i] * g2 - s.z[i] * g0;
    s.J[5][i] = s.y[i] * g0 - s.x[i] * g1;
    s.J[6][i] = -1.0F;
    s.r[i] = r;
    s.w[i] = w;
    s.square[i] = w * r * r;
    s.ok[i] = ok ? 1.0F : 0.0F;
  }
}

LOOPSIFT_SIMD void accumulate(const Block& s, Sums& __restrict sums) {
  accumulate_system<kColumns>(s.J, s.r, s.w, s.count, sums);
  for (int i = 0; i < s.count; i += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      sums[kFirstScalar][l] += s.w[i + l];
      sums[kFirstScalar + 1][l] += s.square[i + l];
      sums[kFirstScalar + 2][l] += s.w[i + l] * s.r[i + l];
      sums[kFirstScalar + 3][l] += s.inside[i + l];
      sums[kFirstScalar + 4][l] += s.ok[i + l];
    }
  }
}

void load(const Keyframe::Level& key, int x0, int y, Block& s) {
  const int count = std::min(kBlock, key.camera.width - x0);
  s.count = (count + kLanes - 1) / kLanes * kLanes;
  std::copy_n(key.depth_m.row(y) + x0, count, s.depth);
  std::copy_n(key.intensity.row(y) + x0, count, s.intensity);
  std::fill(s.depth + count, s.depth + s.count, 0.0F);
  std::fill(s.intensity + count, s.intensity + s.count, 0.0F);
}

Job make_job(const FrameLevel& level, const Keyframe::Level& key, const Se3& T_camera_key,
             const PhotometricSettings& set) {
  const PinholeCamera& c = level.camera;
  Job j{level.intensity.data,
        level.depth_m.data,
        c.width,
        c.height,
        c.fx,
        c.fy,
        c.cx,
        c.cy,
        1.0F / key.camera.fx,
        1.0F / key.camera.fy,
        key.camera.cx,
        key.camera.cy,
        {},
        {},
        set.depth_gate_m,
        1.0F / (set.scale * set.scale),
        set.exposure};
  const Se3f T(T_camera_key);
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) j.R[3 * r + k] = T.R(r, k);
    j.t[r] = T.t[r];
  }
  return j;
}

// Unknown 6, the exposure, is eliminated (Schur complement); sums are brought to the unit of the scale.
PhotometricSystem to_system(const double (&total)[kSums], const PhotometricSettings& set) {
  PhotometricSystem system;
  system.inside = static_cast<int>(total[kFirstScalar + 3]);
  system.seen = static_cast<int>(total[kFirstScalar + 4]);
  const double weight = system.weight = total[kFirstScalar];
  if (system.seen == 0 || weight < kTiny) return system;
  Eigen::Matrix<double, kColumns, kColumns> H;
  Eigen::Matrix<double, kColumns, 1> b;
  int term = 0;
  for (int a = 0; a < kColumns; ++a) {
    for (int c = a; c < kColumns; ++c, ++term) H(a, c) = H(c, a) = total[term];
    b[a] = total[kColumns * (kColumns + 1) / 2 + a];
  }
  const double inverse_scale2 = 1.0 / std::pow(static_cast<double>(set.scale), 2);
  const Vector6d mixed = H.block<6, 1>(0, 6);
  system.H = (H.block<6, 6>(0, 0) - mixed * mixed.transpose() / weight) * inverse_scale2;
  system.b = (b.head<6>() - mixed * (b[6] / weight)) * inverse_scale2;
  const double mean = total[kFirstScalar + 2] / weight;
  const double variance = total[kFirstScalar + 1] / system.seen - mean * mean * weight / system.seen;
  system.scale = static_cast<float>(std::sqrt(std::max(variance, 0.0)));
  system.exposure = set.exposure + static_cast<float>(mean);
  return system;
}

}  // namespace

PhotometricSystem linearize_photometric(const FrameLevel& level, const Keyframe::Level& key,
                                        const Se3& T_camera_key, const PhotometricSettings& settings) {
  const Job job = make_job(level, key, T_camera_key, settings);
  double total[kSums] = {};
  Block block;
  for (int y = 0; y < key.camera.height; ++y) {
    Sums sums = {};
    for (int x0 = 0; x0 < key.camera.width; x0 += kBlock) {
      load(key, x0, y, block);
      project(job, static_cast<float>(x0), static_cast<float>(y), block);
      evaluate(job, block);
      accumulate(block, sums);
    }
    add_sums(sums, kSums, total);
  }
  return to_system(total, settings);
}

}  // namespace loopsift
