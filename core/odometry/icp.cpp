// SPDX-License-Identifier: MIT
#include "core/odometry/icp.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"
#include "core/odometry/normal_equations.hpp"

namespace loopsift {
namespace {

constexpr int kTriangle = 21;            // of H's upper half
constexpr int kScalars = 7;              // weight, scaled squares, squares, valid, met, partners, inliers
constexpr int kCross = sum_count(6, 0);  // first sum of the crossed information
constexpr int kFirstScalar = kCross + kTriangle;
constexpr int kSums = kFirstScalar + kScalars;
constexpr float kStudentNu = 5.0F;

// Everything that does not change from block to block.
struct Job {
  const float *qx, *qy, *qz, *nx, *ny, *nz;  // model
  int model_width, model_height;
  float model_fx, model_fy, model_cx, model_cy;
  float R[9], t[3];  // T_view_camera
  float inverse_fx, inverse_fy, cx, cy;
  float gate, min_cosine, noise_floor, noise_slope, scale;
};

// One block of a row: pixel depths and normals in, points and partners out. Lanes past the row have depth 0.
struct Block {
  int count = 0;  // lanes in use, a multiple of kLanes
  alignas(32) float depth[kBlock], nx[kBlock], ny[kBlock], nz[kBlock];
  alignas(32) float px[kBlock], py[kBlock], pz[kBlock];
  alignas(32) std::int32_t partner[kBlock];
  alignas(32) float seen[kBlock];
  alignas(32) float J[6][kBlock], K[6][kBlock], r[kBlock], w[kBlock];  // K: J by the frame's own normals
  alignas(32) float robust[kBlock], scaled[kBlock], met[kBlock], partnered[kBlock], inlier[kBlock];
};

using Sums = float[kSums][kLanes];

// Points in the view frame and the model pixels that they fall on (nearest).
LOOPSIFT_SIMD void project(const Job& j, float x0, float y, Block& __restrict s) {
  const float ray_y = (y - j.cy) * j.inverse_fy;
  for (int i = 0; i < s.count; ++i) {
    const float z = s.depth[i];
    const float x = (x0 + static_cast<float>(i) - j.cx) * j.inverse_fx * z, yy = ray_y * z;
    const float px = j.R[0] * x + j.R[1] * yy + j.R[2] * z + j.t[0];
    const float py = j.R[3] * x + j.R[4] * yy + j.R[5] * z + j.t[1];
    const float pz = j.R[6] * x + j.R[7] * yy + j.R[8] * z + j.t[2];
    s.px[i] = px;
    s.py[i] = py;
    s.pz[i] = pz;
    const float inverse_z = 1.0F / std::max(pz, 1e-3F);
    const float u = j.model_fx * px * inverse_z + j.model_cx + 0.5F;
    const float v = j.model_fy * py * inverse_z + j.model_cy + 0.5F;
    const bool has_normal = s.nx[i] * s.nx[i] + s.ny[i] * s.ny[i] + s.nz[i] * s.nz[i] > 0.5F;
    const bool valid = (z > 0.0F) & has_normal;
    const bool inside = valid & (pz > 0.05F) & (u >= 0.0F) & (v >= 0.0F) &
                        (u < static_cast<float>(j.model_width)) & (v < static_cast<float>(j.model_height));
    const float su = inside ? u : 0.0F, sv = inside ? v : 0.0F;
    const std::int32_t index = static_cast<std::int32_t>(sv) * j.model_width + static_cast<std::int32_t>(su);
    s.partner[i] = inside ? index : -1;
    s.seen[i] = valid ? 1.0F : 0.0F;
  }
}

// Residuals, Jacobians and weights; weight 0 where there is no partner.
LOOPSIFT_SIMD void evaluate(const Job& j, Block& __restrict s) {
  const float inverse_scale2 = 1.0F / (j.scale * j.scale);
  for (int i = 0; i < s.count; ++i) {
    const std::int32_t k = s.partner[i] < 0 ? 0 : s.partner[i];
    const float qz = j.qz[k], nx = j.nx[k], ny = j.ny[k], nz = j.nz[k];
    const float dx = s.px[i] - j.qx[k], dy = s.py[i] - j.qy[k], dz = s.pz[i] - qz;
    const float r = nx * dx + ny * dy + nz * dz;
    const float fnx = j.R[0] * s.nx[i] + j.R[1] * s.ny[i] + j.R[2] * s.nz[i];
    const float fny = j.R[3] * s.nx[i] + j.R[4] * s.ny[i] + j.R[5] * s.nz[i];
    const float fnz = j.R[6] * s.nx[i] + j.R[7] * s.ny[i] + j.R[8] * s.nz[i];
    const float cosine = nx * fnx + ny * fny + nz * fnz;
    const float z = s.depth[i] - 0.4F, sigma = j.noise_floor + j.noise_slope * z * z;
    const float gate = j.gate + 3.0F * sigma;
    const bool met = (s.partner[i] >= 0) & (qz > 0.0F);
    const bool ok = met & (cosine > j.min_cosine) & (dx * dx + dy * dy + dz * dz < gate * gate);
    const float inverse_sigma2 = 1.0F / (sigma * sigma);
    const float scaled = r * r * inverse_sigma2;
    const float normalized = scaled * inverse_scale2;
    const float robust = ok ? (kStudentNu + 1.0F) / (kStudentNu + normalized) : 0.0F;
    s.r[i] = r;
    s.robust[i] = robust;
    s.scaled[i] = robust * scaled;
    s.w[i] = robust * inverse_sigma2 * inverse_scale2;
    s.met[i] = met ? 1.0F : 0.0F;
    s.partnered[i] = ok ? 1.0F : 0.0F;
    s.inlier[i] = (ok & (normalized < 9.0F)) ? 1.0F : 0.0F;
    s.J[0][i] = nx;
    s.J[1][i] = ny;
    s.J[2][i] = nz;
    s.J[3][i] = s.py[i] * nz - s.pz[i] * ny;
    s.J[4][i] = s.pz[i] * nx - s.px[i] * nz;
    s.J[5][i] = s.px[i] * ny - s.py[i] * nx;
    s.K[0][i] = fnx;
    s.K[1][i] = fny;
    s.K[2][i] = fnz;
    s.K[3][i] = s.py[i] * fnz - s.pz[i] * fny;
    s.K[4][i] = s.pz[i] * fnx - s.px[i] * fnz;
    s.K[5][i] = s.px[i] * fny - s.py[i] * fnx;
  }
}

LOOPSIFT_SIMD void accumulate(const Block& s, Sums& __restrict sums) {
  accumulate_system<6>(s.J, s.r, s.w, s.count, sums);
  for (int i = 0; i < s.count; i += kLanes) {
    int term = kCross;
    for (int a = 0; a < 6; ++a) {
      float wj[kLanes], wk[kLanes];
      for (int l = 0; l < kLanes; ++l) {
        wj[l] = 0.5F * s.w[i + l] * s.J[a][i + l];
        wk[l] = 0.5F * s.w[i + l] * s.K[a][i + l];
      }
      for (int c = a; c < 6; ++c, ++term)
        for (int l = 0; l < kLanes; ++l) sums[term][l] += wj[l] * s.K[c][i + l] + wk[l] * s.J[c][i + l];
    }
    for (int l = 0; l < kLanes; ++l) {
      sums[kFirstScalar][l] += s.robust[i + l];
      sums[kFirstScalar + 1][l] += s.scaled[i + l];
      sums[kFirstScalar + 2][l] += s.inlier[i + l] * s.r[i + l] * s.r[i + l];
      sums[kFirstScalar + 3][l] += s.seen[i + l];
      sums[kFirstScalar + 4][l] += s.met[i + l];
      sums[kFirstScalar + 5][l] += s.partnered[i + l];
      sums[kFirstScalar + 6][l] += s.inlier[i + l];
    }
  }
}

void load(const FrameLevel& level, int x0, int y, Block& s) {
  const int count = std::min(kBlock, level.camera.width - x0);
  s.count = (count + kLanes - 1) / kLanes * kLanes;
  const float* sources[4] = {level.depth_m.row(y) + x0, level.nx.row(y) + x0, level.ny.row(y) + x0,
                             level.nz.row(y) + x0};
  float* targets[4] = {s.depth, s.nx, s.ny, s.nz};
  for (int k = 0; k < 4; ++k) {
    std::copy_n(sources[k], count, targets[k]);
    std::fill(targets[k] + count, targets[k] + s.count, 0.0F);
  }
}

Job make_job(const FrameLevel& level, const ModelView& m, const Se3& T_view_camera, const IcpSettings& set) {
  Job j{m.x.data,
        m.y.data,
        m.z.data,
        m.nx.data,
        m.ny.data,
        m.nz.data,
        m.camera.width,
        m.camera.height,
        m.camera.fx,
        m.camera.fy,
        m.camera.cx,
        m.camera.cy,
        {},
        {},
        1.0F / level.camera.fx,
        1.0F / level.camera.fy,
        level.camera.cx,
        level.camera.cy,
        set.gate_m,
        set.min_normal_cosine,
        set.noise_floor_m,
        set.noise_slope,
        set.scale};
  const Se3f T(T_view_camera);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) j.R[3 * r + c] = T.R(r, c);
    j.t[r] = T.t[r];
  }
  return j;
}

IcpSystem to_system(const double (&total)[kSums]) {
  IcpSystem system;
  int term = 0;
  for (int a = 0; a < 6; ++a) {
    for (int c = a; c < 6; ++c, ++term) {
      system.H(a, c) = system.H(c, a) = total[term];
      system.crossed(a, c) = system.crossed(c, a) = total[kCross + term];
    }
    system.b[a] = total[kTriangle + a];
  }
  system.weight = total[kFirstScalar];
  system.scaled_squares = total[kFirstScalar + 1];
  system.squares_m2 = total[kFirstScalar + 2];
  system.valid = static_cast<int>(total[kFirstScalar + 3]);
  system.met = static_cast<int>(total[kFirstScalar + 4]);
  system.partners = static_cast<int>(total[kFirstScalar + 5]);
  system.inliers = static_cast<int>(total[kFirstScalar + 6]);
  return system;
}

}  // namespace

IcpSystem linearize(const FrameLevel& level, const ModelView& model, const Se3& T_view_camera,
                    const IcpSettings& settings) {
  const Job job = make_job(level, model, T_view_camera, settings);
  double total[kSums] = {};
  Block block;
  for (int y = 0; y < level.camera.height; ++y) {
    Sums sums = {};
    for (int x0 = 0; x0 < level.camera.width; x0 += kBlock) {
      load(level, x0, y, block);
      project(job, static_cast<float>(x0), static_cast<float>(y), block);
      evaluate(job, block);
      accumulate(block, sums);
    }
    add_sums(sums, kSums, total);
  }
  return to_system(total);
}

}  // namespace loopsift
