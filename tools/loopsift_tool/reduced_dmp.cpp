// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/disc_set.hpp"
#include "tools/loopsift_tool/dmp_figures.hpp"
#include "tools/loopsift_tool/offline_map.hpp"
#include "tools/loopsift_tool/residual_image.hpp"

namespace loopsift::tool {
namespace {

int frame_number(const Fragment& fragment, const ScoreView& view) {
  return fragment.frames[static_cast<std::size_t>(view.frame_in_fragment)].frame.value;
}

/// What the scorer compares: the thinned discs of all fragments against a view's measured depth.
Status write_heatmap(const std::vector<DiscSet>& discs, const std::vector<Se3>& T_map_fragment,
                     const ScoreView& view, const Se3& T_map_camera, const std::string& folder, int frame) {
  const PosteriorOptions scoring;
  const int stride = padded_stride(view.camera.width);
  std::vector<float> pixels(static_cast<std::size_t>(stride) * static_cast<std::size_t>(view.camera.height));
  const ImageView<float> predicted(pixels.data(), view.camera.width, view.camera.height, stride);
  for (std::size_t f = 0; f < discs.size(); ++f)
    render_discs(discs[f].discs(), T_map_camera.inverse() * T_map_fragment[f], view.camera,
                 scoring.min_depth_m, scoring.max_depth_m, predicted);
  return write_residual_image(folder, frame, view.depth_m, predicted);
}

Status write_heatmaps(const OfflineMap& map, const std::vector<Se3>& T_map_fragment,
                      const HeatmapOptions& options) {
  if (Status made = make_folder(options.folder); !made) return made;
  std::vector<DiscSet> discs;
  for (const Fragment& fragment : map.fragments())
    discs.push_back(DiscSet::thinned(fragment.surfels, PosteriorOptions()));
  int next = 0;
  for (const Fragment& fragment : map.fragments()) {
    for (const ScoreView& view : fragment.views) {
      const int frame = frame_number(fragment, view);
      if (frame < next) continue;
      next = frame + options.every;
      const Se3 T_map_camera = T_map_fragment[fragment.id.index()] * view.T_fragment_camera;
      if (Status s = write_heatmap(discs, T_map_fragment, view, T_map_camera, options.folder, frame); !s)
        return s;
    }
  }
  return {};
}

}  // namespace

Expected<DmpFigures> reduced_dmp(OfflineMap& map, const std::vector<Se3>& T_map_fragment,
                                 const HeatmapOptions& heatmaps) {
  const MapScorer& scorer = map.back_end(0).scorer();
  std::vector<float> values(static_cast<std::size_t>(scorer.view_count()));
  DmpFigures figures;
  figures.dmp = scorer.dmp(T_map_fragment, values).value;
  figures.views = scorer.view_count();
  figures.valid_pixels = scorer.valid_pixels(T_map_fragment);
  for (const Fragment& fragment : map.fragments()) {
    for (const ScoreView& view : fragment.views) {
      if (figures.per_view.size() == values.size()) break;
      const FragmentFrame& frame = fragment.frames[static_cast<std::size_t>(view.frame_in_fragment)];
      figures.per_view.push_back({frame.frame.value, fragment.id.value,
                                  static_cast<double>(frame.timestamp_ns) * 1e-9,
                                  static_cast<double>(values[figures.per_view.size()])});
    }
  }
  if (!heatmaps.folder.empty())
    if (Status written = write_heatmaps(map, T_map_fragment, heatmaps); !written) return written.error();
  return figures;
}

}  // namespace loopsift::tool
