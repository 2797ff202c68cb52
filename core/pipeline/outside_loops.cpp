// SPDX-License-Identifier: MIT
#include "core/pipeline/outside_loops.hpp"

#include <algorithm>
#include <cstdlib>

namespace loopsift {
namespace {

// Where a moment is on the map.
struct Place {
  enum class Known { kYes, kNotYet, kNever } known = Known::kNever;
  const Fragment* fragment = nullptr;
  Se3 T_fragment_camera;
};

Place find(Span<const Fragment> fragments, std::int64_t timestamp_ns) {
  Place place;
  std::int64_t nearest_ns = OutsideLoops::kSameMoment_ns + 1;
  std::int64_t newest_ns = timestamp_ns;
  for (const Fragment& fragment : fragments)
    for (const FragmentFrame& frame : fragment.frames) {
      newest_ns = frame.timestamp_ns;
      const std::int64_t apart_ns = std::abs(frame.timestamp_ns - timestamp_ns);
      if (apart_ns >= nearest_ns) continue;
      nearest_ns = apart_ns;
      place = {Place::Known::kYes, &fragment, frame.T_fragment_camera};
    }
  const bool ahead = fragments.empty() || newest_ns < timestamp_ns;
  if (place.fragment == nullptr && ahead) place.known = Place::Known::kNotYet;
  return place;
}

Loop between(const Place& i, const Place& j, const OutsideLoop& outside) {
  Loop loop;
  loop.i = i.fragment->id;
  loop.j = j.fragment->id;
  loop.T_i_j = i.T_fragment_camera * outside.T_i_j * j.T_fragment_camera.inverse();
  const Matrix6d A = j.T_fragment_camera.adjoint();
  Matrix6d covariance = A * outside.covariance * A.transpose();
  if (loop.j < loop.i) {
    const Matrix6d B = loop.T_i_j.adjoint();
    covariance = B * covariance * B.transpose();
    loop.T_i_j = loop.T_i_j.inverse();
    std::swap(loop.i, loop.j);
  }
  loop.information = covariance.inverse();
  return loop;
}

}  // namespace

void OutsideLoops::add(const OutsideLoop& loop) {
  if (waiting_.size() == kWaiting) {
    waiting_.erase(waiting_.begin());
    ++left_out_;
  }
  waiting_.push_back(loop);
}

std::vector<Loop> OutsideLoops::resolve(Span<const Fragment> fragments) {
  std::vector<Loop> loops;
  std::vector<OutsideLoop> still_waiting;
  for (const OutsideLoop& outside : waiting_) {
    const Place i = find(fragments, outside.timestamp_i_ns), j = find(fragments, outside.timestamp_j_ns);
    const bool never = i.known == Place::Known::kNever || j.known == Place::Known::kNever;
    if (never || (i.fragment != nullptr && i.fragment == j.fragment)) {
      ++left_out_;
    } else if (i.fragment == nullptr || j.fragment == nullptr) {
      still_waiting.push_back(outside);
    } else {
      loops.push_back(between(i, j, outside));
    }
  }
  waiting_.swap(still_waiting);
  return loops;
}

}  // namespace loopsift
