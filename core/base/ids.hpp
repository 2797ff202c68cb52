// SPDX-License-Identifier: MIT
// Strong index types: a fragment's number cannot be passed where a frame's is meant.
#pragma once
#include <cstdint>

namespace loopsift {

/// A dense index from 0 with its own type. Invalid until set.
template <class Tag>
struct Id {
  std::int32_t value = -1;
  [[nodiscard]] bool valid() const { return value >= 0; }
  /// As an array index; only when valid().
  [[nodiscard]] std::size_t index() const { return static_cast<std::size_t>(value); }
  friend bool operator==(Id a, Id b) { return a.value == b.value; }
  friend bool operator!=(Id a, Id b) { return a.value != b.value; }
  friend bool operator<(Id a, Id b) { return a.value < b.value; }
};

using FrameId = Id<struct FrameTag>;        ///< order of arrival at the front thread
using FragmentId = Id<struct FragmentTag>;  ///< order of creation
using LoopId = Id<struct LoopTag>;          ///< order of proposal, stable for a run

}  // namespace loopsift
