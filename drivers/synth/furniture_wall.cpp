// SPDX-License-Identifier: MIT
// What hangs on walls or stands in corners: pictures, windows, doors, lamps, plants.
#include "drivers/synth/furniture.hpp"
#include "drivers/synth/furniture_parts.hpp"

namespace loopsift {

void add_floor_lamp(SceneBuilder& b, std::uint64_t look) {
  b.cylinder({0, 0.2F, 0}, 0.15F, 0.03F, metal());
  b.cylinder({0, 0.2F, 0.03F}, 0.015F, 1.4F, metal());
  b.frustum({0, 0.2F, 1.4F}, 0.2F, 0.12F, 0.28F, fabric(look));
}

void add_picture(SceneBuilder& b, float width, float height, std::uint64_t look) {
  Dice dice(look);
  const float half = 0.5F * width, border = 0.03F;
  b.box({-half, 0, 0}, {half, 0.025F, height}, wood(look));
  b.box({-half + border, 0.025F, border}, {half - border, 0.03F, height - border},
        {any_color(dice), any_color(dice), Pattern::kPicture, dice.between(0.5F, 0.9F)});
}

void add_plant(SceneBuilder& b, float height, std::uint64_t look) {
  b.frustum({0, 0.25F, 0}, 0.12F, 0.18F, 0.3F, paint(look));
  b.cylinder({0, 0.25F, 0.3F}, 0.02F, 0.6F * height - 0.3F, wood(look));
  Dice dice(look + 1);
  for (int i = 0; i < 14; ++i) {
    const float angle = dice.between(0, 6.2831853F), reach = dice.between(0.05F, 0.22F);
    const float z = dice.between(0.4F, 0.95F) * height, size = dice.between(0.05F, 0.13F);
    b.ellipsoid({reach * std::cos(angle), 0.25F + reach * std::sin(angle), z}, {size, size, 0.6F * size},
                foliage());
  }
}

void add_window(SceneBuilder& b, float width, std::uint64_t look) {
  const float half = 0.5F * width;
  for (const float x : {-half, -0.03F, half - 0.06F})
    b.box({x, 0, 0.95F}, {x + 0.06F, 0.05F, 2.15F}, white());
  for (const float z : {0.95F, 2.09F}) b.box({-half, 0, z}, {half, 0.05F, z + 0.06F}, white());
  b.box({-half, 0, 1.0F}, {half, 0.01F, 2.1F},
        {{0.75F, 0.85F, 0.95F}, {0.35F, 0.5F, 0.4F}, Pattern::kPicture, 1.4F});
  b.box({-half - 0.05F, 0, 0.91F}, {half + 0.05F, 0.2F, 0.95F}, white());
  const Material curtain = fabric(look);
  for (int i = 0; i < 4; ++i) {
    const float x = half + 0.02F + 0.085F * static_cast<float>(i),
                y = 0.08F + 0.02F * static_cast<float>(i % 2);
    b.cylinder({x, y, 0.1F}, 0.05F, 2.2F, curtain);
    b.cylinder({-x, y, 0.1F}, 0.05F, 2.2F, curtain);
  }
  b.box({-0.4F * width, 0.02F, 0.12F}, {0.4F * width, 0.05F, 0.7F}, white());
  for (float x = -0.4F * width; x < 0.4F * width; x += 0.07F)
    b.box({x, 0.05F, 0.14F}, {x + 0.035F, 0.09F, 0.68F}, white());
}

void add_door(SceneBuilder& b, std::uint64_t look) {
  const Material leaf = wood(look), frame = white();
  b.box({-0.43F, 0, 0}, {0.43F, 0.03F, 2.0F}, leaf);
  for (const float z : {0.2F, 1.1F}) b.box({-0.3F, 0.03F, z}, {0.3F, 0.045F, z + 0.75F}, leaf);
  for (const float x : {-0.5F, 0.43F}) b.box({x, 0, 0}, {x + 0.07F, 0.06F, 2.07F}, frame);
  b.box({-0.5F, 0, 2.0F}, {0.5F, 0.06F, 2.07F}, frame);
  b.box({0.3F, 0.03F, 1.0F}, {0.4F, 0.09F, 1.03F}, metal());
}

}  // namespace loopsift
