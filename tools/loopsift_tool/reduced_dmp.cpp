// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/dmp_figures.hpp"
#include "tools/loopsift_tool/offline_map.hpp"

namespace loopsift::tool {

DmpFigures reduced_dmp(OfflineMap& map, const std::vector<Se3>& T_map_fragment) {
  const MapScorer& scorer = map.back_end(0).scorer();
  std::vector<float> values(static_cast<std::size_t>(scorer.view_count()));
  DmpFigures figures;
  figures.dmp = scorer.score(T_map_fragment, ScoreKind::kPlain, {}, values).value;
  figures.views = scorer.view_count();
  figures.valid_pixels = scorer.valid_pixels(T_map_fragment);
  for (const Fragment& fragment : map.fragments()) {
    for (const ScoreView& view : fragment.views) {
      if (figures.per_view.size() == values.size()) return figures;
      const FragmentFrame& frame = fragment.frames[static_cast<std::size_t>(view.frame_in_fragment)];
      figures.per_view.push_back({frame.frame.value, fragment.id.value,
                                  static_cast<double>(frame.timestamp_ns) * 1e-9,
                                  static_cast<double>(values[figures.per_view.size()])});
    }
  }
  return figures;
}

}  // namespace loopsift::tool
