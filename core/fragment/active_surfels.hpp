// SPDX-License-Identifier: MIT
// The surfels of the fragment being built, and the fusion of one frame into them (Keller et al. 2013,
// sections 4–5): surfels are drawn as points into an index map at the frame's resolution; each measured pixel
// updates the surfel that it falls on, or becomes a new one; surfels that the camera sees through are worn
// down and removed. Capacity: FragmentOptions::active_capacity; past it no surfel is added (counted). Thread:
// front. No allocation after construction.
#pragma once
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/fragment/fragment.hpp"
#include "core/fragment/fragment_options.hpp"
#include "core/fragment/surfel_arrays.hpp"
#include "core/frame/frame.hpp"

namespace loopsift {

class ActiveSurfels {
 public:
  ActiveSurfels(const FragmentOptions& options, const PinholeCamera& working, Arena& arena);
  /// Fuses level 0 of a frame seen from T_fragment_camera. Frames are numbered from 0 after clear(); of more
  /// than 65536 the numbers start again.
  void fuse(const Frame& frame, const Se3& T_fragment_camera);
  /// Removes surfels that were measured in fewer frames.
  void drop_seldom_seen(int min_frames);
  void clear() {
    count_ = 0;
    frame_ = 0;
  }
  /// In the fragment's frame, in order of creation.
  [[nodiscard]] SurfelSpan surfels() const { return slice(surfels_, 0, count_); }
  [[nodiscard]] std::size_t capacity() const { return surfels_.size(); }
  [[nodiscard]] std::size_t high_water() const { return high_water_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  // A measured pixel in the fragment's frame.
  struct Measurement {
    Eigen::Vector3f point, normal;
    float depth, weight, radius;
    std::uint32_t rgb;
    std::uint16_t frame;
  };
  void draw_index_map(const Se3& T_fragment_camera);
  void fuse_pixel(const Frame& frame, const Se3f& T_fragment_camera, int x, int y);
  [[nodiscard]] std::int32_t find(int x, int y, float depth, const Eigen::Vector3f& normal) const;
  void update(std::size_t surfel, const Measurement& m);
  void add(const Measurement& m);
  void wear_down(const Frame& frame, int x, int y);
  void remove_unconfirmed();
  template <class Keep>
  void compact(Keep keep);

  FragmentOptions options_;
  PinholeCamera camera_;
  SurfelSpan surfels_;
  Span<std::uint16_t> seen_;  // frames in which each surfel was measured, less those that saw through it
  std::size_t count_ = 0, high_water_ = 0;
  std::uint16_t frame_ = 0;  // number of the next frame
  std::uint64_t refused_ = 0;
  Span<std::int32_t> index_;  // surfel behind each pixel, −1: none
  Span<float> index_depth_;   // its depth
  Span<float> projected_;     // scratch: depth of each surfel in the frame
  Span<std::int32_t> pixel_;  // scratch: pixel of each surfel, −1: out of sight
};

}  // namespace loopsift
