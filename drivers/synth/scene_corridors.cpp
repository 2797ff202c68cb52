// SPDX-License-Identifier: MIT
// Two corridors: one of equal alcoves, one of almost nothing.
#include "drivers/synth/builtin_scenes.hpp"
#include "drivers/synth/furniture.hpp"

namespace loopsift {
namespace {

constexpr float kHeight = 2.5F;
constexpr int kAlcoves = 5;
constexpr float kPitch = 2.3F;  // from alcove to alcove
constexpr float kPier = 0.3F;   // wall between two alcoves
constexpr float kMouth = 0.9F;  // y of the alcoves' mouth
constexpr float kBack = 2.5F;   // y of their back wall

const Material kFloor{{0.6F, 0.58F, 0.52F}, {0.35F, 0.34F, 0.33F}, Pattern::kTiles, kPitch};
const Material kCeiling{{0.9F, 0.9F, 0.88F}, {0.75F, 0.75F, 0.74F}, Pattern::kMottled, kPitch};
const Material kPlaster{{0.8F, 0.76F, 0.7F}, {0.58F, 0.56F, 0.54F}, Pattern::kMottled, kPitch / 2};
const Material kWeak{{0.78F, 0.77F, 0.74F}, {0.7F, 0.7F, 0.68F}, Pattern::kMottled, 2.5F};

/// One alcove from x to x + kPitch: the same furniture and the same textures every time.
void build_alcove(SceneBuilder& b, float x) {
  const float left = x + kPier, right = x + kPitch, middle = 0.5F * (left + right);
  b.place({x, 0, 0});
  b.box({0, kMouth, 0}, {kPier, kBack, kHeight}, kPlaster);
  b.box({kPier, kBack, 0}, {kPitch, kBack + 0.1F, kHeight}, kPlaster);
  b.place({middle - 0.25F, kBack - 0.02F, 0, 180}), add_desk(b, 1.3F, 201);
  b.place({middle - 0.3F, kBack - 0.9F, 0, -10}), add_chair(b, 202);
  b.place({right - 0.3F, kBack - 0.01F, 0, 180}), add_bookshelf(b, 0.5F, 1.9F, 203);
  b.place({middle - 0.2F, kBack, 1.45F, 180}), add_picture(b, 0.8F, 0.5F, 204);
  b.place({left, 1.5F, 1.3F, -90}), add_picture(b, 0.5F, 0.6F, 205);
  b.place({x + 0.5F * kPitch + 0.15F, -0.9F, 0, 0}), add_door(b, 206);
}

}  // namespace

BuiltinScene make_lookalike_scene() {
  SceneBuilder b;
  const float length = kAlcoves * kPitch + kPier;
  add_floor_and_ceiling(b, 0, -0.95F, length, kBack, kHeight, kFloor, kCeiling);
  add_wall(b, 0, -0.95F, length, -0.95F, kHeight, kPlaster);
  add_wall(b, 0, -0.95F, 0, kBack, kHeight, kPlaster);
  add_wall(b, length, -0.95F, length, kBack, kHeight, kPlaster);
  for (int i = 0; i < kAlcoves; ++i) build_alcove(b, kPitch * static_cast<float>(i));
  b.place({length - kPier, 0, 0});
  b.box({0, kMouth, 0}, {kPier, kBack, kHeight}, kPlaster);
  b.place({1.0F * kPitch + 0.5F, 1.3F, 0, -40}), add_plant(b, 1.2F, 211);
  b.place({3.0F * kPitch + 1.9F, 1.1F, 0, 20}), add_crates(b, 212);
  b.place({length - 0.05F, 0.1F, 1.2F, 90}), add_picture(b, 0.8F, 0.8F, 213);
  const double far = static_cast<double>(length) - 1.1;
  return {b.finish(),
          {{1.0, -0.2, 1.4, 78, -16, 0},
           {0.5 * far, -0.25, 1.42, 72, -18, 0},
           {far, -0.2, 1.4, 76, -15, 0},
           {far + 0.1, -0.3, 1.4, 45, -12, 0},
           {far, -0.4, 1.4, 85, -15, 0},
           {0.5 * far, -0.4, 1.38, 96, -17, 0},
           {0.9, -0.35, 1.4, 92, -15, 0}},
          {}};
}

BuiltinScene make_corridor_scene() {
  SceneBuilder b;
  const float length = 15.0F;
  add_floor_and_ceiling(b, 0, -1, length, 1, kHeight, kWeak, kWeak);
  add_wall(b, 0, -1, length, -1, kHeight, kWeak);
  add_wall(b, 0, 1, length, 1, kHeight, kWeak);
  add_wall(b, 0, -1, 0, 1, kHeight, kWeak);
  add_wall(b, length, -1, length, 1, kHeight, kWeak);
  b.place({4.4F, 0.95F, 0, 180}), add_door(b, 221);
  b.place({8.3F, -0.95F, 0, 0}), add_door(b, 222);
  b.place({12.6F, 0.95F, 0, 180}), add_door(b, 223);
  return {b.finish(),
          {{0.8, -0.1, 1.4, 18, -14, 0},
           {4.0, 0.1, 1.42, 24, -16, 0},
           {8.0, -0.1, 1.4, -22, -15, 0},
           {11.6, 0.0, 1.4, 15, -14, 0}},
          {}};
}

}  // namespace loopsift
