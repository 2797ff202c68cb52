// SPDX-License-Identifier: MIT
#include "core/proposal/point_grid.hpp"

#include <algorithm>
#include <limits>

namespace loopsift {

CellBox CellBox::around(Span<const Eigen::Vector3f> points, float margin_m, float cell_m, int max_cells) {
  CellBox box;
  box.cell_m = cell_m;
  if (points.empty()) return box;
  Eigen::Vector3f low = points[0], high = points[0];
  for (const Eigen::Vector3f& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  low.array() -= margin_m;
  high.array() += margin_m;
  box.origin = low;
  for (;; box.cell_m *= 1.25F) {
    const Eigen::Array3d cells = ((high - low) / box.cell_m).array().floor().cast<double>() + 1;
    if (cells.prod() > max_cells) continue;
    box.size = cells.cast<int>();
    return box;
  }
}

void RadiusIndex::build(Span<const Eigen::Vector3f> points, float max_radius_m) {
  constexpr int kMaxCells = 1 << 18;
  box_ = CellBox::around(points, 0, max_radius_m, kMaxCells);
  starts_.assign(box_.cell_count() + 2, 0);
  for (const Eigen::Vector3f& p : points) ++starts_[box_.index(box_.cell_of(p)) + 2];
  for (std::size_t c = 2; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  order_.resize(points.size());
  sorted_points_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t k = starts_[box_.index(box_.cell_of(points[i])) + 1]++;
    order_[k] = static_cast<std::uint32_t>(i);
    sorted_points_[k] = points[i];
  }
}

void NearestField::build(Span<const Eigen::Vector3f> points, float reach_m, float cell_m, int max_cells) {
  box_ = CellBox::around(points, reach_m, cell_m, max_cells);
  inverse_cell_ = 1.0F / box_.cell_m;
  limit_ = box_.size.cast<float>();
  cells_.assign(box_.cell_count(), kNone);
  squared_distances_.assign(box_.cell_count(), std::numeric_limits<std::uint16_t>::max());
  const std::size_t count = std::min<std::size_t>(points.size(), kNone);
  for (std::size_t i = 0; i < count; ++i) seed(points[i], static_cast<std::uint16_t>(i), reach_m);
}

void NearestField::seed(const Eigen::Vector3f& p, std::uint16_t index, float reach_m) {
  const Eigen::Array3i low = box_.cell_of(p - Eigen::Vector3f::Constant(reach_m)).max(0);
  const Eigen::Array3i high = box_.cell_of(p + Eigen::Vector3f::Constant(reach_m)).min(box_.size - 1);
  constexpr float kFarthest = std::numeric_limits<std::uint16_t>::max() - 1;  // nearer than no point at all
  const float unit = 0.5F * kFarthest / (reach_m * reach_m);
  const Eigen::Vector3f to_first_centre = box_.origin + (low.cast<float>() + 0.5F).matrix() * box_.cell_m - p;
  for (int z = low.z(); z <= high.z(); ++z) {
    const float dz = to_first_centre.z() + static_cast<float>(z - low.z()) * box_.cell_m;
    for (int y = low.y(); y <= high.y(); ++y) {
      const float dy = to_first_centre.y() + static_cast<float>(y - low.y()) * box_.cell_m;
      const float row = dz * dz + dy * dy;
      if (row > reach_m * reach_m) continue;
      const std::size_t first = box_.index({low.x(), y, z});
      for (int x = 0; x <= high.x() - low.x(); ++x) {
        const float dx = to_first_centre.x() + static_cast<float>(x) * box_.cell_m;
        const auto d2 = static_cast<std::uint16_t>(std::min(unit * (row + dx * dx), kFarthest));
        const std::size_t cell = first + static_cast<std::size_t>(x);
        const bool nearer = d2 < squared_distances_[cell];
        squared_distances_[cell] = nearer ? d2 : squared_distances_[cell];
        cells_[cell] = nearer ? index : cells_[cell];
      }
    }
  }
}

}  // namespace loopsift
