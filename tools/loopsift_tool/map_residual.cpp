// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/map_residual.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "core/posterior/disc_renderer.hpp"
#include "tools/evaluation/point_ply.hpp"
#include "tools/loopsift_tool/disc_set.hpp"
#include "tools/loopsift_tool/posed_sequence.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {
namespace {

constexpr int kWidth = 160, kViews = 400;
constexpr std::size_t kBatch = 16;  // views measured at a time
constexpr double kMaxGap_s = 0.1;
constexpr float kMinDepth_m = 0.3F, kMaxDepth_m = 15.0F;
constexpr float kVisible_m = 0.02F;  // a surfel this close to what is seen at its pixel is seen

struct RunFragment {
  std::size_t first = 0;  // surfel of the map
  DiscSet discs;          // in the corrected map's frame
  Se3 T_odom_map;         // where the odometry had it
};

/// One view with the fragments in one of the two states.
struct Measurement {
  Se3 T_camera_world;
  std::vector<std::pair<std::uint32_t, float>> seen;  // surfel, residual in metres
  double sum = 0;                                     // squared residuals
  std::size_t pixels = 0;
  [[nodiscard]] double mean() const { return pixels == 0 ? 0.0 : sum / static_cast<double>(pixels); }
};

struct MeasuredView {
  MapResidual::View view;
  std::vector<float> depth_m;  // reduced; 0 invalid
  Measurement before, after;
};

bool in_range(float depth_m) { return depth_m > kMinDepth_m && depth_m < kMaxDepth_m; }

void look(const RunFragment& fragment, const Se3f& T_camera_discs, const PinholeCamera& camera,
          const std::vector<float>& depth_m, const ImageView<float>& inverse_depth, Measurement* out) {
  const ScoreSurfels& s = fragment.discs.discs();
  for (std::size_t k = 0; k < s.size(); ++k) {
    const Eigen::Vector3f p = T_camera_discs * Eigen::Vector3f(s.x[k], s.y[k], s.z[k]);
    if (!in_range(p.z())) continue;
    const auto x = static_cast<int>(std::lround(camera.fx * p.x() / p.z() + camera.cx));
    const auto y = static_cast<int>(std::lround(camera.fy * p.y() / p.z() + camera.cy));
    if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) continue;
    const Eigen::Vector3f normal = T_camera_discs.R * Eigen::Vector3f(s.nx[k], s.ny[k], s.nz[k]);
    const float measured = depth_m[static_cast<std::size_t>(y * camera.width + x)];
    const float inverse = inverse_depth(x, y);
    if (normal.dot(p) >= 0 || !in_range(measured) || !(inverse > 0)) continue;
    const float predicted = 1.0F / inverse;
    if (std::abs(predicted - p.z()) > std::max(kVisible_m, s.radius[k])) continue;
    out->seen.emplace_back(static_cast<std::uint32_t>(fragment.first + k), std::abs(predicted - measured));
  }
}

void measure(const std::vector<RunFragment>& map, bool before, const PinholeCamera& camera,
             const std::vector<float>& depth_m, Measurement* out) {
  const int stride = padded_stride(camera.width);
  std::vector<float> pixels(static_cast<std::size_t>(stride) * static_cast<std::size_t>(camera.height));
  const ImageView<float> inverse_depth(pixels.data(), camera.width, camera.height, stride);
  const auto T_camera_discs = [&](const RunFragment& fragment) {
    return before ? out->T_camera_world * fragment.T_odom_map : out->T_camera_world;
  };
  for (const RunFragment& fragment : map)
    render_discs(fragment.discs.discs(), T_camera_discs(fragment), camera, kMinDepth_m, kMaxDepth_m,
                 inverse_depth);
  for (const RunFragment& fragment : map)
    look(fragment, Se3f(T_camera_discs(fragment)), camera, depth_m, inverse_depth, out);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const float measured = depth_m[static_cast<std::size_t>(y * camera.width + x)];
      if (!in_range(measured) || !(inverse_depth(x, y) > 0)) continue;
      const double residual = 1.0 / static_cast<double>(inverse_depth(x, y)) - static_cast<double>(measured);
      out->sum += residual * residual;
      ++out->pixels;
    }
  }
}

/// Means by surfel, of residuals added one by one.
class SurfelMeans {
 public:
  explicit SurfelMeans(std::size_t count) : sum_(count), seen_(count) {}
  void add(const Measurement& measurement) {
    for (const auto& [surfel, residual] : measurement.seen) {
      sum_[surfel] += residual;
      ++seen_[surfel];
    }
  }
  [[nodiscard]] std::vector<float> means() const {
    std::vector<float> means(sum_.size(), std::numeric_limits<float>::quiet_NaN());
    for (std::size_t k = 0; k < means.size(); ++k)
      if (seen_[k] > 0) means[k] = sum_[k] / static_cast<float>(seen_[k]);
    return means;
  }

 private:
  std::vector<float> sum_;
  std::vector<std::uint32_t> seen_;
};

Expected<std::vector<RunFragment>> read_fragments(const MapResidualInput& input) {
  const auto columns = read_ply_columns(input.map, {"x", "y", "z", "nx", "ny", "nz", "radius"});
  if (!columns) return columns.error();
  const auto parts = read_ply_fragments(input.map);
  if (!parts) return parts.error();
  std::vector<RunFragment> map;
  std::size_t first = 0;
  for (const PlyFragment& part : *parts) {
    if (first + part.surfels > columns->front().size()) break;
    Se3 T_odom_camera, T_map_camera;
    if (!input.T_odom_camera->at(part.first_frame_s, kMaxGap_s, &T_odom_camera) ||
        !input.T_map_camera->at(part.first_frame_s, kMaxGap_s, &T_map_camera))
      return Error{ErrorCode::kFormat, input.map + ": a fragment begins at " +
                                           std::to_string(part.first_frame_s) +
                                           " s, where the trajectories have no pose; are they of one run?"};
    std::array<Span<const float>, 7> own;
    for (std::size_t c = 0; c < own.size(); ++c) own[c] = {(*columns)[c].data() + first, part.surfels};
    map.push_back({first, DiscSet::of(own), T_odom_camera * T_map_camera.inverse()});
    first += part.surfels;
  }
  if (first == columns->front().size() && !map.empty()) return map;
  return Error{ErrorCode::kFormat, input.map +
                                       ": does not say which surfels each fragment has; give the map "
                                       "as the run wrote it"};
}

/// Takes frames in, measures them in batches.
class ResidualMeter {
 public:
  ResidualMeter(const std::vector<RunFragment>& map, const SourceInfo& info)
      : map_(map),
        unit_m_(info.depth_unit_m),
        step_(std::max(1, info.camera.width / kWidth)),
        camera_(info.camera.subsampled(step_, step_ / 2)),
        before_(surfels()),
        after_(surfels()) {}

  void add(const PosedFrame& posed, const Se3& T_map_camera) {
    MeasuredView view;
    view.view.frame = posed.number.value;
    view.view.time_s = static_cast<double>(posed.raw->timestamp_ns) * 1e-9;
    view.before.T_camera_world = posed.pose.T_odom_camera.inverse();
    view.after.T_camera_world = T_map_camera.inverse();
    view.depth_m.reserve(static_cast<std::size_t>(camera_.width * camera_.height));
    for (int y = 0; y < camera_.height; ++y)
      for (int x = 0; x < camera_.width; ++x) {
        const std::uint16_t raw = posed.raw->depth(step_ / 2 + step_ * x, step_ / 2 + step_ * y);
        view.depth_m.push_back(raw == 65535 ? 0.0F : static_cast<float>(raw * unit_m_));
      }
    batch_.push_back(std::move(view));
    if (batch_.size() == kBatch) measure_batch();
  }
  [[nodiscard]] MapResidual finish() {
    measure_batch();
    result_.before_m = before_.means();
    result_.after_m = after_.means();
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::size_t surfels() const { return map_.back().first + map_.back().discs.discs().size(); }
  void measure_batch() {
#pragma omp parallel for schedule(dynamic)
    for (std::size_t k = 0; k < 2 * batch_.size(); ++k) {
      MeasuredView& view = batch_[k / 2];
      measure(map_, k % 2 == 0, camera_, view.depth_m, k % 2 == 0 ? &view.before : &view.after);
    }
    for (MeasuredView& view : batch_) {
      before_.add(view.before);
      after_.add(view.after);
      view.view.before_m2 = view.before.mean();
      view.view.after_m2 = view.after.mean();
      result_.views.push_back(view.view);
    }
    batch_.clear();
  }

  const std::vector<RunFragment>& map_;
  double unit_m_;
  int step_;
  PinholeCamera camera_;
  SurfelMeans before_, after_;
  std::vector<MeasuredView> batch_;
  MapResidual result_;
};

Status meter_all(PosedSequence* sequence, std::int64_t frame_count, const Trajectory& T_map_camera,
                 ResidualMeter* meter) {
  Ticker ticker("comparing the map with frame");
  const std::int64_t every = std::max<std::int64_t>(1, frame_count / kViews);
  while (true) {
    const Expected<const PosedFrame*> posed = sequence->next();
    if (!posed) return posed.error();
    if (*posed == nullptr) return {};
    const PosedFrame& frame = **posed;
    Se3 pose;
    if (frame.number.value % every != 0 ||
        !T_map_camera.at(static_cast<double>(frame.raw->timestamp_ns) * 1e-9, kMaxGap_s, &pose))
      continue;
    meter->add(frame, pose);
    ticker.update(static_cast<std::size_t>(frame.number.value), static_cast<std::size_t>(frame_count));
  }
}

}  // namespace

Expected<MapResidual> measure_map_residual(const MapResidualInput& input) {
  const auto map = read_fragments(input);
  if (!map) return map.error();
  SourceOptions source_options;
  source_options.want_color = false;
  const auto source = open_source(input.source, source_options);
  if (!source) return source.error();
  const auto odometry = GivenOdometry::open(input.odometry, "");
  if (!odometry) return odometry.error();
  Arena measuring;
  { const PosedSequence measured(**source, *odometry, measuring); }
  Arena arena(measuring.used_bytes());
  PosedSequence sequence(**source, *odometry, arena);
  ResidualMeter meter(*map, (*source)->info());
  if (Status read = meter_all(&sequence, (*source)->info().frame_count, *input.T_map_camera, &meter); !read)
    return read.error();
  MapResidual residual = meter.finish();
  if (!residual.views.empty()) return residual;
  return Error{ErrorCode::kUsage, odometry->extent() + "; no frame of '" + (*source)->info().description +
                                      "' is among them: is --source the recording of this run?"};
}

}  // namespace loopsift::tool
