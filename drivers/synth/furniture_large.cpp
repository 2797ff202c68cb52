// SPDX-License-Identifier: MIT
// Walls and the pieces that stand on the floor.
#include "drivers/synth/furniture.hpp"
#include "drivers/synth/furniture_parts.hpp"

namespace loopsift {
namespace {

constexpr float kWallThickness = 0.1F;

/// A point of the object moved into the world: where a part with a placement of its own goes.
Placement relative(const Placement& at, float x, float y, float z, float yaw_deg = 0) {
  const float angle = at.yaw_deg * 3.14159265F / 180.0F, c = std::cos(angle), s = std::sin(angle);
  return {at.x + c * x - s * y, at.y + s * x + c * y, at.z + z, at.yaw_deg + yaw_deg};
}

}  // namespace

void add_wall(SceneBuilder& b, float x0, float y0, float x1, float y1, float height, const Material& material,
              const std::vector<Opening>& openings) {
  const float length = std::hypot(x1 - x0, y1 - y0), half = 0.5F * kWallThickness;
  b.place({x0, y0, 0, std::atan2(y1 - y0, x1 - x0) * 180.0F / 3.14159265F});
  float from = 0;
  for (const Opening& opening : openings) {
    b.box({from, -half, 0}, {opening.from, half, height}, material);
    b.box({opening.from, -half, opening.height}, {opening.to, half, height}, material);
    for (const float x : {opening.from, opening.to})  // the door frame stands out a little
      b.box({x - 0.05F, -half - 0.02F, 0}, {x + 0.05F, half + 0.02F, opening.height + 0.05F}, wood(77));
    from = opening.to;
  }
  b.box({from, -half, 0}, {length, half, height}, material);
}

void add_floor_and_ceiling(SceneBuilder& b, float x0, float y0, float x1, float y1, float height,
                           const Material& floor, const Material& ceiling) {
  b.place({});
  b.box({x0, y0, -kWallThickness}, {x1, y1, 0}, floor);
  b.box({x0, y0, height}, {x1, y1, height + kWallThickness}, ceiling);
}

void add_table(SceneBuilder& b, float width, float depth, float height, std::uint64_t look) {
  const Material material = wood(look);
  const float half = 0.5F * width, leg = 0.06F, top = 0.04F;
  b.box({-half, 0, height - top}, {half, depth, height}, material);
  for (const float x : {-half + 0.04F, half - 0.04F - leg})
    for (const float y : {0.04F, depth - 0.04F - leg})
      b.box({x, y, 0}, {x + leg, y + leg, height - top}, material);
  b.box({-half + 0.1F, 0.06F, height - 0.12F}, {half - 0.1F, 0.08F, height - top}, material);
}

void add_chair(SceneBuilder& b, std::uint64_t look) {
  const Material frame = wood(look), seat = fabric(look + 1);
  b.box({-0.21F, 0, 0.42F}, {0.21F, 0.42F, 0.47F}, seat);
  for (const float x : {-0.21F, 0.17F}) {
    b.box({x, 0, 0}, {x + 0.04F, 0.04F, 0.92F}, frame);
    b.box({x, 0.38F, 0}, {x + 0.04F, 0.42F, 0.42F}, frame);
  }
  for (const float z : {0.58F, 0.7F, 0.82F}) b.box({-0.17F, 0.01F, z}, {0.17F, 0.03F, z + 0.07F}, frame);
}

void add_bookshelf(SceneBuilder& b, float width, float height, std::uint64_t look) {
  const Material board = wood(look);
  const float half = 0.5F * width, depth = 0.3F, thick = 0.025F;
  b.box({-half, 0, 0}, {half, 0.015F, height}, board);
  b.box({-half, 0, 0}, {-half + thick, depth, height}, board);
  b.box({half - thick, 0, 0}, {half, depth, height}, board);
  const int levels = static_cast<int>(height / 0.36F);
  const float pitch = (height - thick) / static_cast<float>(levels);
  Dice dice(look + 11);
  for (int level = 0; level <= levels; ++level) {
    const float z = static_cast<float>(level) * pitch;
    b.box({-half, 0, z}, {half, depth, z + thick}, board);
    if (level == levels) break;
    for (float x = -half + 0.04F; x < half - 0.1F;) {
      const float w = dice.between(0.025F, 0.065F);
      if (dice.between(0, 1) < 0.12F) {
        x += dice.between(0.06F, 0.2F);  // a gap between the books
        continue;
      }
      const float d = dice.between(0.14F, 0.24F), h = dice.between(0.19F, pitch - 0.05F);
      b.box({x, 0.02F, z + thick}, {x + w, 0.02F + d, z + thick + h},
            paint(look * 131 + static_cast<std::uint64_t>(1000.0F * (x + z + 3.0F))));
      x += w + 0.004F;
    }
  }
}

void add_cupboard(SceneBuilder& b, float width, float depth, float height, std::uint64_t look) {
  const Material body = wood(look), door = paint(look + 3);
  const float half = 0.5F * width;
  b.box({-half, 0, 0.06F}, {half, depth, height}, body);
  b.box({-half + 0.04F, 0, 0}, {half - 0.04F, depth - 0.06F, 0.06F}, metal());
  b.box({-half - 0.02F, 0, height}, {half + 0.02F, depth + 0.03F, height + 0.03F}, body);
  const int doors = std::max(2, static_cast<int>(width / 0.45F));
  const float pitch = width / static_cast<float>(doors);
  for (int i = 0; i < doors; ++i) {
    const float x = -half + pitch * static_cast<float>(i);
    b.box({x + 0.015F, depth, 0.1F}, {x + pitch - 0.015F, depth + 0.02F, height - 0.04F}, door);
    b.box({x + pitch - 0.07F, depth + 0.02F, 0.5F * height},
          {x + pitch - 0.05F, depth + 0.05F, 0.5F * height + 0.14F}, metal());
  }
}

void add_sofa(SceneBuilder& b, float width, std::uint64_t look) {
  const Material cover = fabric(look);
  const float half = 0.5F * width, arm = 0.18F;
  b.box({-half, 0, 0.08F}, {half, 0.85F, 0.3F}, cover);
  b.box({-half, 0, 0.3F}, {half, 0.22F, 0.82F}, cover);
  b.box({-half, 0, 0.3F}, {-half + arm, 0.85F, 0.6F}, cover);
  b.box({half - arm, 0, 0.3F}, {half, 0.85F, 0.6F}, cover);
  const int seats = width > 1.5F ? 3 : 2;
  const float pitch = (width - 2.0F * arm) / static_cast<float>(seats);
  for (int i = 0; i < seats; ++i) {
    const float x = -half + arm + pitch * static_cast<float>(i);
    b.box({x + 0.01F, 0.2F, 0.3F}, {x + pitch - 0.01F, 0.87F, 0.44F}, cover);
    b.ellipsoid({x + 0.5F * pitch, 0.3F, 0.62F}, {0.42F * pitch, 0.1F, 0.19F},
                fabric(look + 20 + static_cast<std::uint64_t>(i % 2)));
  }
}

void add_bed(SceneBuilder& b, float width, float length, std::uint64_t look) {
  const float half = 0.5F * width;
  b.box({-half, 0, 0}, {half, 0.06F, 0.95F}, wood(look));
  b.box({-half, 0.06F, 0.12F}, {half, length, 0.32F}, wood(look));
  b.box({-half + 0.02F, 0.08F, 0.32F}, {half - 0.02F, length - 0.02F, 0.5F}, white());
  b.box({-half - 0.01F, 0.75F, 0.28F}, {half + 0.01F, length + 0.01F, 0.55F}, fabric(look + 5));
  b.ellipsoid({-0.25F * width, 0.35F, 0.55F}, {0.23F * width, 0.2F, 0.1F}, fabric(look + 6));
  b.ellipsoid({0.25F * width, 0.38F, 0.56F}, {0.21F * width, 0.2F, 0.11F}, fabric(look + 7));
}

void add_desk(SceneBuilder& b, float width, std::uint64_t look) {
  const float half = 0.5F * width;
  add_table(b, width, 0.65F, 0.74F, look);
  b.box({half - 0.42F, 0.05F, 0.05F}, {half - 0.08F, 0.6F, 0.68F}, paint(look + 1));
  b.cylinder({-0.1F, 0.22F, 0.74F}, 0.1F, 0.015F, metal());
  b.cylinder({-0.1F, 0.18F, 0.74F}, 0.02F, 0.2F, metal());
  b.box({-0.37F, 0.2F, 0.86F}, {0.17F, 0.23F, 1.2F}, metal());
  Dice dice(look);
  b.box({-0.355F, 0.23F, 0.875F}, {0.155F, 0.232F, 1.185F},
        {any_color(dice), any_color(dice), Pattern::kPicture, 0.5F});
  b.box({-0.33F, 0.4F, 0.74F}, {0.12F, 0.54F, 0.76F}, metal());
  b.cylinder({0.3F, 0.45F, 0.74F}, 0.04F, 0.1F, paint(look + 2));
  const Placement at = b.placement();
  b.place(relative(at, 0.35F * width, 0.2F, 0.74F, 15));
  b.box({-0.11F, -0.15F, 0}, {0.11F, 0.15F, 0.06F}, paint(look + 4));
  b.place(relative(at, -0.38F * width, 0.3F, 0.74F, -20));
  b.box({-0.105F, -0.15F, 0}, {0.105F, 0.15F, 0.02F}, white());
  b.place(at);
}

void add_crates(SceneBuilder& b, std::uint64_t look) {
  const Placement at = b.placement();
  float z = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const float s = 0.24F - 0.04F * static_cast<float>(i), h = 0.36F - 0.05F * static_cast<float>(i);
    b.place(relative(at, 0.03F * static_cast<float>(i), 0.3F, z, 23.0F * static_cast<float>(i) - 10.0F));
    b.box({-s, -s, 0}, {s, s, h}, i == 1 ? paint(look + i) : wood(look + i));
    z += h;
  }
  b.place(at);
}

void add_clutter(SceneBuilder& b, float width, float depth, int count, std::uint64_t look) {
  const Placement at = b.placement();
  Dice dice(look);
  for (int i = 0; i < count; ++i) {
    const float x = dice.between(-0.5F, 0.5F) * width, y = dice.between(0, depth);
    b.place(relative(at, x, y, 0, dice.between(-60, 60)));
    const Material material = paint(look * 31 + static_cast<std::uint64_t>(i));
    const float size = dice.between(0.03F, 0.08F), height = dice.between(0.05F, 0.25F);
    if (i % 3 == 0)
      b.box({-size, -0.7F * size, 0}, {size, 0.7F * size, height}, material);
    else if (i % 3 == 1)
      b.frustum({0, 0, 0}, 0.6F * size, 0.8F * size, height, material);
    else
      b.ellipsoid({0, 0, 0.8F * size}, {size, size, 0.8F * size}, material);
  }
  b.place(at);
}

}  // namespace loopsift
