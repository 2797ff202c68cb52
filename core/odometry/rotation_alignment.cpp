// SPDX-License-Identifier: MIT
#include "core/odometry/rotation_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/simd.hpp"
#include "core/geometry/se3.hpp"
#include "core/odometry/normal_equations.hpp"

namespace loopsift {
namespace {

constexpr int kWidest = 48;                    // pixels of level 0 in either direction, at most
constexpr int kColumns = 4;                    // three of the turn, one of the mean difference
constexpr int kSums = sum_count(kColumns, 3);  // and weight, weighted squares, pixels
constexpr int kFirstScalar = kSums - 3;
constexpr int kIterations = 10;
constexpr double kConverged = 1e-3;  // radians
constexpr float kStudentNu = 5.0F;

// Negative log-likelihood per pixel under Laplace's distribution of unknown width; infinity if nothing
// compares.
float cost_of(const TurnDifference& difference) {
  float cost = 0;
  int channels = 0;
  for (const float mean : difference.mean) {
    if (mean < 0) continue;
    cost += std::log(mean);
    ++channels;
  }
  return channels == 0 ? std::numeric_limits<float>::infinity() : cost;
}

struct Row {
  alignas(32) float J[kColumns][kBlock], r[kBlock], w[kBlock], square[kBlock], ok[kBlock];
  int count = 0;
};

struct Linearization {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};

struct ChannelScale {
  float scale, offset;  // of the differences; offset: e
};

// r = kept(π(q)) − present − e at q = R d; for R ← exp(ω) R: ∂r/∂ω = q × a, a = ∇kept ∂π/∂q.
LOOPSIFT_SIMD void evaluate(const DirectionImages& kept, const float* image, const float* present,
                            const float* R, const PinholeCamera& c, int y, const ChannelScale& s,
                            Row& __restrict row) {
  const int stride = kept.camera.width;
  const float fx = kept.camera.fx, fy = kept.camera.fy, cx = kept.camera.cx, cy = kept.camera.cy;
  const auto last_u = static_cast<float>(kept.camera.width - 1),
             last_v = static_cast<float>(kept.camera.height - 1);
  const float dy = (static_cast<float>(y) - c.cy) / c.fy, inverse_fx = 1.0F / c.fx;
  const float inverse_scale2 = 1.0F / (s.scale * s.scale);
  for (int x = 0; x < c.width; ++x) {
    const float dx = (static_cast<float>(x) - c.cx) * inverse_fx;
    const float qx = R[0] * dx + R[1] * dy + R[2], qy = R[3] * dx + R[4] * dy + R[5];
    const float qz = R[6] * dx + R[7] * dy + R[8];
    const float inverse_z = 1.0F / std::max(qz, 0.05F);
    const float u = fx * qx * inverse_z + cx, v = fy * qy * inverse_z + cy;
    const bool inside = (qz > 0.05F) & (u >= 0.0F) & (v >= 0.0F) & (u < last_u) & (v < last_v);
    const float su = inside ? u : 0.0F, sv = inside ? v : 0.0F;
    const auto iu = static_cast<std::int32_t>(su), iv = static_cast<std::int32_t>(sv);
    const float* corner = image + iv * stride + iu;
    const float p = corner[0], q = corner[1], m = corner[stride], n = corner[stride + 1];
    const float fu = su - static_cast<float>(iu), fv = sv - static_cast<float>(iv);
    const bool ok = inside & (std::min(std::min(p, q), std::min(m, n)) > DirectionImages::kLeast) &
                    (present[x] > DirectionImages::kLeast);
    const float gx = (q - p) + fv * ((n - m) - (q - p)), gy = (m - p) + fu * ((n - q) - (m - p));
    const float r = ok ? p + fu * (q - p) + fv * gy - present[x] - s.offset : 0.0F;
    const float ax = gx * fx * inverse_z, ay = gy * fy * inverse_z, az = -(ax * qx + ay * qy) * inverse_z;
    const float w = ok ? (kStudentNu + 1.0F) / (kStudentNu + r * r * inverse_scale2) : 0.0F;
    row.J[0][x] = qy * az - qz * ay;
    row.J[1][x] = qz * ax - qx * az;
    row.J[2][x] = qx * ay - qy * ax;
    row.J[3][x] = -1.0F;
    row.r[x] = r;
    row.w[x] = w;
    row.square[x] = w * r * r;
    row.ok[x] = ok ? 1.0F : 0.0F;
  }
}

LOOPSIFT_SIMD void accumulate(const Row& row, float (*__restrict sums)[kLanes]) {
  accumulate_system<kColumns>(row.J, row.r, row.w, row.count, sums);
  for (int i = 0; i < row.count; i += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      sums[kFirstScalar][l] += row.w[i + l];
      sums[kFirstScalar + 1][l] += row.square[i + l];
      sums[kFirstScalar + 2][l] += row.ok[i + l];
    }
  }
}

// Adds one channel's system, e eliminated, in units of its scale; the scale and e of the next iteration.
void add_channel(const DirectionImages& kept, const DirectionImages& present, std::size_t channel,
                 const Eigen::Matrix3d& R, ChannelScale* s, Linearization* to) {
  float turn[9];
  for (int k = 0; k < 9; ++k) turn[k] = static_cast<float>(R(k / 3, k % 3));
  const PinholeCamera& c = present.camera;
  double total[kSums] = {};
  Row row = {};
  row.count = (c.width + kLanes - 1) / kLanes * kLanes;
  for (int y = 0; y < c.height; ++y) {
    float sums[kSums][kLanes] = {};
    evaluate(kept, kept.channel[channel].data(), present.channel[channel].data() + y * c.width, turn, c, y,
             *s, row);
    accumulate(row, sums);
    add_sums(sums, kSums, total);
  }
  const double weight = total[kFirstScalar], seen = total[kFirstScalar + 2];
  if (4.0 * seen < c.width * c.height || weight <= 0) return;
  Eigen::Matrix4d H;
  Eigen::Vector4d b;
  int term = 0;
  for (int i = 0; i < kColumns; ++i) {
    for (int j = i; j < kColumns; ++j, ++term) H(i, j) = H(j, i) = total[term];
    b[i] = total[kColumns * (kColumns + 1) / 2 + i];
  }
  const Eigen::Vector3d mixed = H.topRightCorner<3, 1>();
  const double inverse_scale2 = 1.0 / (static_cast<double>(s->scale) * static_cast<double>(s->scale));
  to->H += inverse_scale2 * (H.topLeftCorner<3, 3>() - mixed * mixed.transpose() / weight);
  to->b += inverse_scale2 * (b.head<3>() - mixed * (b[3] / weight));
  const double mean = -b[3] / weight;
  s->offset += static_cast<float>(mean);
  s->scale = std::max(static_cast<float>(std::sqrt(
                          std::max(0.0, total[kFirstScalar + 1] / seen - mean * mean * weight / seen))),
                      kLeastDifference);
}

}  // namespace

RotationAlignment::RotationAlignment(const PinholeCamera& coarsest, Arena& arena) {
  while (std::max(coarsest.width, coarsest.height) / step_ > kWidest) step_ *= 2;
  for (Pyramid* pyramid : {&kept_, &present_}) {
    for (std::size_t l = 0; l < kLevels; ++l) {
      DirectionImages& images = (*pyramid)[l];
      images.camera = coarsest.block_averaged(l == 0 ? step_ : 2 * step_);
      const auto pixels =
          static_cast<std::size_t>(images.camera.width) * static_cast<std::size_t>(images.camera.height);
      for (Span<float>& channel : images.channel) channel = arena.carve<float>("odometry/turn", pixels);
    }
  }
}

void RotationAlignment::keep(const Frame& frame) {
  draw(frame, kept_);
  has_kept_ = true;
}

void RotationAlignment::draw(const Frame& frame, const Pyramid& to) const {
  draw_directions(frame.levels[static_cast<std::size_t>(frame.level_count) - 1], step_, to[0]);
  halve_directions(to[0], to[1]);
}

Eigen::Matrix3d RotationAlignment::search(const Eigen::Matrix3d& R_kept_guess, TurnDifference* best) const {
  const PinholeCamera& c = kept_[1].camera;
  *best = compare_turned(kept_[1], present_[1], R_kept_guess);
  float least = cost_of(*best);
  Eigen::Matrix3d R = R_kept_guess;
  for (int j = -c.height / 2; j <= c.height / 2; ++j) {
    for (int i = -c.width / 2; i <= c.width / 2; ++i) {
      const double about_y = std::atan(i / static_cast<double>(c.fx)),
                   about_x = std::atan(j / static_cast<double>(c.fy));
      const Eigen::Matrix3d turned = so3_exp({about_x, about_y, 0}) * R_kept_guess;
      const TurnDifference difference = compare_turned(kept_[1], present_[1], turned);
      const float cost = cost_of(difference);
      if (!(cost < least)) continue;
      least = cost;
      *best = difference;
      R = turned;
    }
  }
  return R;
}

std::optional<Eigen::Matrix3d> RotationAlignment::find(const Frame& frame,
                                                       const Eigen::Matrix3d& R_kept_guess) {
  const PinholeCamera& smallest = kept_[1].camera;
  if (!has_kept_ || smallest.width < 2 || smallest.height < 2) return std::nullopt;
  draw(frame, present_);
  TurnDifference best;
  Eigen::Matrix3d R = search(R_kept_guess, &best);
  std::array<ChannelScale, 2> scales = {{{best.mean[0], 0.0F}, {best.mean[1], 0.0F}}};
  for (int i = 0; i < kIterations; ++i) {
    Linearization system;
    for (std::size_t c = 0; c < scales.size(); ++c)
      if (best.mean[c] > 0) add_channel(kept_[0], present_[0], c, R, &scales[c], &system);
    if (system.H.isZero(0.0)) return std::nullopt;
    const Eigen::Vector3d turn = -system.H.ldlt().solve(system.b);
    if (!turn.allFinite()) return std::nullopt;
    R = so3_exp(turn) * R;
    if (turn.norm() < kConverged) break;
  }
  return R;
}

}  // namespace loopsift
