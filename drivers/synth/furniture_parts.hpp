// SPDX-License-Identifier: MIT
// Materials and chance shared by the pieces of furniture.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "drivers/synth/random.hpp"
#include "drivers/synth/scene.hpp"

namespace loopsift {

/// A short reproducible sequence of random numbers.
class Dice {
 public:
  explicit Dice(std::uint64_t look) : look_(look) {}
  float between(float low, float high) { return low + (high - low) * uniform(mix(look_, ++count_)); }

 private:
  std::uint64_t look_;
  std::uint64_t count_ = 0;
};

/// A saturated colour anywhere on the colour wheel.
inline Eigen::Vector3f any_color(Dice& dice) {
  const float hue = dice.between(0.0F, 6.2831853F);
  const float value = dice.between(0.4F, 0.75F), chroma = dice.between(0.1F, 0.3F);
  return {value + chroma * std::cos(hue), value + chroma * std::cos(hue - 2.0944F),
          value + chroma * std::cos(hue + 2.0944F)};
}

inline Material wood(std::uint64_t look) {
  Dice dice(look);
  const float tone = dice.between(0.4F, 0.8F);
  const Eigen::Vector3f base(tone, tone * dice.between(0.65F, 0.8F), tone * dice.between(0.4F, 0.55F));
  return {base, base * 0.55F, Pattern::kWood, dice.between(0.7F, 1.1F)};
}

inline Material fabric(std::uint64_t look) {
  Dice dice(look);
  const Eigen::Vector3f base = any_color(dice);
  return {base, base * 0.5F, dice.between(0, 1) < 0.5F ? Pattern::kStripes : Pattern::kMottled,
          dice.between(0.35F, 0.6F)};
}

inline Material paint(std::uint64_t look) {
  Dice dice(look);
  const Eigen::Vector3f base = any_color(dice);
  return {base, base * 0.75F, Pattern::kMottled, 0.4F};
}

inline Material metal() { return {{0.32F, 0.33F, 0.35F}, {0.22F, 0.22F, 0.24F}, Pattern::kMottled, 0.3F}; }

inline Material white() { return {{0.88F, 0.87F, 0.84F}, {0.74F, 0.74F, 0.72F}, Pattern::kMottled, 0.7F}; }

inline Material foliage() { return {{0.25F, 0.5F, 0.2F}, {0.1F, 0.25F, 0.1F}, Pattern::kMottled, 0.25F}; }

}  // namespace loopsift
