// SPDX-License-Identifier: MIT
// The model that the odometry tracks against: the active fragment's surfels and those of the fragments before
// it, splatted as discs with a z-buffer into a ModelView. Where fragments overlap the older surface stands,
// so that drift does not start afresh with every fragment. In: fragments and a pose. Out: ModelView, valid
// until the next render. Thread: front. No allocation after construction.
#pragma once
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/fragment/fragment.hpp"
#include "core/odometry/odometry.hpp"

namespace loopsift {

struct ModelOptions {
  int fragments = 8;  ///< how many closed fragments the model reaches back
  int step = 1;       ///< working pixels per model pixel in each direction
  float same_surface_m =
      0.05F;                 ///< a newer surface within this of an older one is the same: the older stands
  int max_splat_radius = 4;  ///< model pixels
};
[[nodiscard]] Status validate(const ModelOptions& options);

class ModelRenderer {
 public:
  /// working is the camera of Frame::levels[0].
  ModelRenderer(const ModelOptions& options, const PinholeCamera& working, Arena& arena);
  /// Renders closed (those of the current piece of trajectory, oldest first; the last options.fragments are
  /// used) and active (in T_odom_active, with its Fragment::disparity_unknown) as seen from T_odom_view.
  const ModelView& render(Span<const Fragment> closed, const SurfelSpan& active, const Se3& T_odom_active,
                          const Se3& T_odom_view, float active_unknown = 1.0F);

 private:
  // What a pixel shows, until all surfels are drawn.
  struct Pixel {
    float z;         // metres; 0: nothing
    float priority;  // generation (older fragments first), then squared distance from the surfel's centre
    std::uint32_t layer;   // which of layers_
    std::uint32_t surfel;  // in that layer
  };
  struct Layer {
    SurfelSpan surfels;
    Se3f T_view_surfels;
    float disparity_unknown;
    int pixels;  // of the view that show it
  };
  void splat(const Layer& layer, std::uint32_t index);
  void resolve();
  [[nodiscard]] float least_known(std::size_t layers) const;

  ModelOptions options_;
  ModelView view_;
  Span<Pixel> pixels_;
  Span<Layer> layers_;
  Span<float> x_, y_, z_, nx_, ny_, nz_;
};

}  // namespace loopsift
