// SPDX-License-Identifier: MIT
// Random numbers as pure functions of their arguments, so that a frame or an object does not depend on what
// was made before it, nor on the order of threads. Never allocates.
#pragma once
#include <cstdint>

namespace loopsift {

/// 64 well-mixed bits of two numbers (the finaliser of SplitMix64; Steele et al. 2014).
[[nodiscard]] inline std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
  std::uint64_t z = a * 0x9E3779B97F4A7C15ULL + b + 0x632BE59BD9B4E019ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

/// In [0, 1), from the upper bits.
[[nodiscard]] inline float uniform(std::uint64_t bits) {
  return static_cast<float>(bits >> 40) * (1.0F / 16777216.0F);
}

/// Zero mean, unit variance, within ±3.5: the sum of the four bytes of a word, close to normal (Irwin–Hall).
[[nodiscard]] inline float gaussian(std::uint32_t bits) {
  const std::uint32_t pairs = (bits & 0x00FF00FFU) + ((bits >> 8) & 0x00FF00FFU);
  const auto sum = static_cast<float>((pairs & 0xFFFFU) + (pairs >> 16));
  return (sum - 510.0F) * (1.0F / 147.801F);  // the variance of four bytes is 4 · (256² − 1) / 12
}

}  // namespace loopsift
