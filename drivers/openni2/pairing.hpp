// SPDX-License-Identifier: MIT
// Which colour image goes with a depth image, when they arrive in any order. Times are the device's, µs.
// Never allocates.
#pragma once
#include <cstdint>
#include <optional>

namespace loopsift::openni2 {

enum class PairStep {
  kWait,       ///< the colour image of the depth image may still come
  kPair,       ///< they belong together
  kAlone,      ///< the depth image has no colour image
  kDropColor,  ///< the colour image is of an earlier depth image; ask again without it
};

/// For a depth image that waits. Its colour image is the first one within half a frame of it; it is given up
/// when a later colour image or the next depth image is here.
[[nodiscard]] constexpr PairStep pair_step(std::int64_t depth_us, std::optional<std::int64_t> color_us,
                                           bool next_depth_is_here, std::int64_t half_frame_us) {
  if (!color_us) return next_depth_is_here ? PairStep::kAlone : PairStep::kWait;
  if (*color_us < depth_us - half_frame_us) return PairStep::kDropColor;
  return *color_us > depth_us + half_frame_us ? PairStep::kAlone : PairStep::kPair;
}

}  // namespace loopsift::openni2
