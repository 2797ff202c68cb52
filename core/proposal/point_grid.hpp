// SPDX-License-Identifier: MIT
// Two indices over a point set, both dense grids over its bounding box, both rebuilt in place. Thread: back.
// Buffers are reused.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/span.hpp"

namespace loopsift {

/// A box of cubic cells. Cells are made larger than asked when the box would hold more than max_cells.
struct CellBox {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();  ///< corner of cell (0, 0, 0), metres
  Eigen::Array3i size = Eigen::Array3i::Zero();      ///< cells along each axis
  float cell_m = 0;

  [[nodiscard]] static CellBox around(Span<const Eigen::Vector3f> points, float margin_m, float cell_m,
                                      int max_cells);
  [[nodiscard]] Eigen::Array3i cell_of(const Eigen::Vector3f& p) const {
    return ((p - origin) / cell_m).array().floor().cast<int>();
  }
  [[nodiscard]] bool contains(const Eigen::Array3i& c) const { return (c >= 0).all() && (c < size).all(); }
  [[nodiscard]] std::size_t index(const Eigen::Array3i& c) const {
    return static_cast<std::size_t>((c.z() * size.y() + c.y()) * size.x() + c.x());
  }
  [[nodiscard]] std::size_t cell_count() const { return static_cast<std::size_t>(size.prod()); }
};

/// All points within a radius of one, exactly.
class RadiusIndex {
 public:
  /// `points` must outlive the queries. max_radius_m: the largest radius that will be asked for.
  void build(Span<const Eigen::Vector3f> points, float max_radius_m);

  /// Calls f(index, squared distance) for every point within radius_m of p (p itself included), in an order
  /// that depends on the points alone.
  template <class F>
  void for_each_within(const Eigen::Vector3f& p, float radius_m, F f) const {
    const Eigen::Array3i low = box_.cell_of(p - Eigen::Vector3f::Constant(radius_m)).max(0);
    const Eigen::Array3i high = box_.cell_of(p + Eigen::Vector3f::Constant(radius_m)).min(box_.size - 1);
    const float squared_radius = radius_m * radius_m;
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        if (low.x() > high.x()) continue;
        const std::size_t begin = starts_[box_.index({low.x(), y, z})];
        const std::size_t end = starts_[box_.index({high.x(), y, z}) + 1];
        for (std::size_t k = begin; k < end; ++k) {
          const float d2 = (sorted_points_[k] - p).squaredNorm();
          if (d2 <= squared_radius) f(order_[k], d2);
        }
      }
    }
  }

 private:
  CellBox box_;
  std::vector<std::uint32_t> starts_;  ///< first entry of each cell, and the end
  std::vector<std::uint32_t> order_;   ///< point indices by cell
  std::vector<Eigen::Vector3f> sorted_points_;
};

/// The nearest point in constant time: every cell within reach of the points stores the one nearest to its
/// centre. The answer is exact up to the cell's half diagonal, which registration does not notice.
class NearestField {
 public:
  static constexpr std::uint16_t kNone = 0xFFFF;

  /// At most 65534 points. reach_m: how far from a point answers are given.
  void build(Span<const Eigen::Vector3f> points, float reach_m, float cell_m, int max_cells);

  /// Index of the point nearest to p's cell; kNone where none is within reach.
  [[nodiscard]] std::uint16_t nearest(const Eigen::Vector3f& p) const {
    const Eigen::Vector3f q = (p - box_.origin) * inverse_cell_;
    if (!((q.array() >= 0).all() && (q.array() < limit_).all())) return kNone;
    return cells_[box_.index(q.array().cast<int>())];
  }

 private:
  void seed(const Eigen::Vector3f& p, std::uint16_t index, float reach_m);

  CellBox box_;
  float inverse_cell_ = 0;
  Eigen::Array3f limit_ = Eigen::Array3f::Zero();
  std::vector<std::uint16_t> cells_;
  std::vector<std::uint16_t> squared_distances_;  ///< to the cells' centres, 2 reach² / 65534 units
};

}  // namespace loopsift
