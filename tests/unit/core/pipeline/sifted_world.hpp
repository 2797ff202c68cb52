// SPDX-License-Identifier: MIT
// A back end, in an arena of the measured size, and the frames of a world of fragments.
#pragma once
#include <vector>

#include "core/pipeline/back_end.hpp"
#include "core/pipeline/corrected_trajectory.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift::test {

inline BackEndOptions small_back_end(bool propose) {
  BackEndOptions options;
  options.propose = propose;
  options.calibrate_odometry = false;  // the world's odometry is honest
  options.posterior.max_fragments = options.proposal.max_fragments = 8;
  options.posterior.max_discs_per_fragment = 10000;
  options.posterior.max_view_width = 80, options.posterior.max_view_height = 60;
  return options;
}

/// As the back thread does: the fragment, and all the sifting that there is to do. True when the corrections
/// changed.
inline bool grow(BackEnd* back_end, const Fragment& fragment) {
  const int before = back_end->sifter().epoch();
  if (!back_end->add_fragment(fragment)) return false;
  while (back_end->work(1)) {
  }
  return back_end->sifter().epoch() != before;
}

inline std::vector<OdometryPose> frames_of(const FragmentWorld& world) {
  std::vector<OdometryPose> frames;
  for (const Fragment& fragment : world.fragments())
    for (const FragmentFrame& frame : fragment.frames)
      frames.push_back({frame.timestamp_ns, fragment.T_odom_fragment * frame.T_fragment_camera});
  return frames;
}

template <class T>
Span<const T> view_of(const std::vector<T>& values) {
  return {values.data(), values.size()};
}

}  // namespace loopsift::test
