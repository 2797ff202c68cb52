// SPDX-License-Identifier: MIT
// Three rooms on a corridor. Living room and bedroom lie north of it and are joined by a door; the study lies
// south. The way: corridor, living room, bedroom, corridor, study, corridor, start.
#include "drivers/synth/builtin_scenes.hpp"
#include "drivers/synth/furniture.hpp"

namespace loopsift {
namespace {

constexpr float kHeight = 2.5F;

const Material kFloor{{0.55F, 0.5F, 0.45F}, {0.3F, 0.28F, 0.27F}, Pattern::kTiles, 2.0F};
const Material kBoards{{0.6F, 0.45F, 0.3F}, {0.4F, 0.28F, 0.18F}, Pattern::kWood, 1.2F};
const Material kCarpet{{0.35F, 0.42F, 0.5F}, {0.55F, 0.6F, 0.62F}, Pattern::kMottled, 0.8F};
const Material kCeiling{{0.9F, 0.9F, 0.88F}, {0.75F, 0.75F, 0.74F}, Pattern::kMottled, 1.0F};
const Material kPlaster{{0.82F, 0.8F, 0.74F}, {0.6F, 0.6F, 0.56F}, Pattern::kMottled, 1.0F};
const Material kStriped{{0.75F, 0.68F, 0.7F}, {0.56F, 0.47F, 0.52F}, Pattern::kStripes, 0.9F};
const Material kGreen{{0.62F, 0.72F, 0.6F}, {0.42F, 0.52F, 0.42F}, Pattern::kMottled, 0.8F};

void build_shell(SceneBuilder& b) {
  add_floor_and_ceiling(b, 0, -0.9F, 9, 0.9F, kHeight, kFloor, kCeiling);
  add_floor_and_ceiling(b, 0, 0.9F, 4.4F, 4.9F, kHeight, kBoards, kCeiling);
  add_floor_and_ceiling(b, 4.4F, 0.9F, 9, 4.9F, kHeight, kCarpet, kCeiling);
  add_floor_and_ceiling(b, 2.5F, -4.7F, 7.5F, -0.9F, kHeight, kBoards, kCeiling);
  add_wall(b, 0, 0.9F, 9, 0.9F, kHeight, kPlaster, {{1.7F, 2.7F}, {7.0F, 8.0F}});
  add_wall(b, 0, -0.9F, 9, -0.9F, kHeight, kPlaster, {{5.2F, 6.2F}});
  add_wall(b, 0, -0.9F, 0, 4.9F, kHeight, kPlaster);
  add_wall(b, 9, -0.9F, 9, 4.9F, kHeight, kStriped);
  add_wall(b, 0, 4.9F, 9, 4.9F, kHeight, kPlaster);
  add_wall(b, 4.4F, 0.9F, 4.4F, 4.9F, kHeight, kStriped, {{1.8F, 2.8F}});
  add_wall(b, 2.5F, -4.7F, 7.5F, -4.7F, kHeight, kGreen);
  add_wall(b, 2.5F, -4.7F, 2.5F, -0.9F, kHeight, kGreen);
  add_wall(b, 7.5F, -4.7F, 7.5F, -0.9F, kHeight, kGreen);
}

void furnish_corridor(SceneBuilder& b) {
  const auto at = [&](float x, float y, float z, float yaw) { b.place({x, y, z, yaw}); };
  at(0.8F, 0.85F, 1.2F, 180), add_picture(b, 0.7F, 0.6F, 101);
  at(3.6F, 0.85F, 0, 180), add_cupboard(b, 0.9F, 0.3F, 0.85F, 102);
  at(3.6F, 0.82F, 0.88F, 180), add_clutter(b, 0.8F, 0.2F, 6, 103);
  at(3.6F, 0.85F, 1.4F, 180), add_picture(b, 0.5F, 0.7F, 104);
  at(5.7F, 0.85F, 1.3F, 180), add_picture(b, 1.1F, 0.6F, 105);
  at(1.5F, -0.85F, 0, 0), add_bookshelf(b, 0.8F, 1.8F, 106);
  at(3.3F, -0.85F, 0, 0), add_door(b, 107);
  at(4.5F, -0.85F, 1.3F, 0), add_picture(b, 0.5F, 0.5F, 108);
  at(7.2F, -0.85F, 0, 0), add_chair(b, 109);
  at(8.4F, -0.85F, 0, 0), add_plant(b, 1.4F, 110);
  at(8.95F, 0, 1.2F, 90), add_picture(b, 0.9F, 0.9F, 111);
  at(0.05F, -0.2F, 0, -90), add_door(b, 112);
}

void furnish_living_room(SceneBuilder& b) {
  const auto at = [&](float x, float y, float z, float yaw) { b.place({x, y, z, yaw}); };
  at(2.2F, 4.84F, 0, 180), add_sofa(b, 2.0F, 121);
  at(2.2F, 4.85F, 1.3F, 180), add_picture(b, 1.2F, 0.7F, 122);
  at(3.8F, 4.84F, 0, 180), add_floor_lamp(b, 123);
  at(0.06F, 2.4F, 0, -90), add_bookshelf(b, 1.6F, 2.0F, 124);
  at(0.3F, 4.5F, 0, -120), add_plant(b, 1.6F, 125);
  at(0.08F, 3.8F, 0, -90), add_cupboard(b, 0.8F, 0.4F, 0.7F, 126);
  at(0.1F, 3.8F, 0.73F, -90), add_clutter(b, 0.6F, 0.3F, 6, 127);
  at(2.3F, 3.1F, 0, 170), add_table(b, 1.1F, 0.6F, 0.45F, 128);
  at(2.3F, 3.0F, 0.45F, 170), add_clutter(b, 0.9F, 0.4F, 7, 129);
  at(4.34F, 4.0F, 1.2F, 90), add_picture(b, 0.8F, 1.0F, 130);
  at(4.33F, 1.6F, 0, 90), add_cupboard(b, 0.9F, 0.35F, 1.3F, 131);
  at(0.8F, 0.96F, 0, 0), add_chair(b, 132);
}

void furnish_bedroom(SceneBuilder& b) {
  const auto at = [&](float x, float y, float z, float yaw) { b.place({x, y, z, yaw}); };
  at(7.3F, 4.84F, 0, 180), add_bed(b, 1.5F, 2.0F, 141);
  at(5.2F, 4.84F, 0, 180), add_cupboard(b, 1.2F, 0.55F, 2.0F, 142);
  at(6.3F, 4.8F, 0, 180), add_cupboard(b, 0.4F, 0.35F, 0.5F, 143);
  at(6.3F, 4.75F, 0.53F, 180), add_clutter(b, 0.3F, 0.2F, 4, 144);
  at(8.94F, 2.2F, 0, 90), add_window(b, 1.3F, 145);
  at(8.8F, 4.5F, 0, 90), add_floor_lamp(b, 146);
  at(7.3F, 4.85F, 1.3F, 180), add_picture(b, 1.3F, 0.6F, 147);
  at(5.6F, 0.96F, 0, 0), add_desk(b, 1.3F, 148);
  at(5.5F, 1.75F, 0, 190), add_chair(b, 149);
  at(4.46F, 4.2F, 1.3F, -90), add_picture(b, 0.5F, 0.6F, 150);
}

void furnish_study(SceneBuilder& b) {
  const auto at = [&](float x, float y, float z, float yaw) { b.place({x, y, z, yaw}); };
  at(3.6F, -4.64F, 0, 0), add_bookshelf(b, 1.8F, 2.1F, 161);
  at(5.6F, -4.64F, 0, 0), add_desk(b, 1.6F, 162);
  at(5.5F, -3.8F, 0, 170), add_chair(b, 163);
  at(5.6F, -4.65F, 1.4F, 0), add_picture(b, 1.0F, 0.6F, 164);
  at(7.0F, -4.5F, 0, 20), add_crates(b, 165);
  at(7.44F, -3.0F, 0, 90), add_bookshelf(b, 1.2F, 1.3F, 166);
  at(7.3F, -3.0F, 1.32F, 90), add_clutter(b, 1.0F, 0.2F, 8, 167);
  at(7.45F, -1.6F, 1.2F, 90), add_picture(b, 0.6F, 0.8F, 168);
  at(2.56F, -2.6F, 0, -90), add_sofa(b, 1.4F, 169);
  at(2.55F, -2.6F, 1.3F, -90), add_picture(b, 0.9F, 0.6F, 170);
  at(2.9F, -1.2F, 0, 180), add_plant(b, 1.3F, 171);
  at(4.4F, -2.9F, 0, 60), add_table(b, 0.9F, 0.6F, 0.7F, 172);
  at(4.3F, -2.85F, 0.7F, 60), add_clutter(b, 0.7F, 0.4F, 6, 173);
  at(4.2F, -0.96F, 0, 180), add_cupboard(b, 1.0F, 0.4F, 1.6F, 174);
}

/// Yaw only ever turns on; 360 degrees are one round.
std::vector<Waypoint> tour() {
  return {{0.9, 0.0, 1.4, 0, -12, 0},     {1.6, 0.0, 1.4, 30, -12, 0},    {2.2, 0.6, 1.4, 90, -14, 0},
          {2.2, 1.6, 1.4, 120, -16, 0},   {1.6, 2.2, 1.4, 160, -14, 0},   {1.4, 2.8, 1.4, 100, -16, 0},
          {2.2, 2.4, 1.4, 60, -16, 0},    {3.0, 2.9, 1.4, 30, -14, 0},    {3.7, 3.2, 1.4, 20, -20, 0},
          {5.0, 3.2, 1.4, 50, -18, 0},    {5.8, 3.0, 1.4, 70, -16, 0},    {6.1, 2.5, 1.4, 10, -14, 0},
          {6.8, 2.2, 1.4, -40, -14, 0},   {7.3, 1.8, 1.4, -90, -10, 0},   {7.5, 0.7, 1.4, -110, -12, 0},
          {7.2, 0.0, 1.4, -160, -12, 0},  {6.2, -0.1, 1.4, -140, -12, 0}, {5.7, -0.6, 1.4, -90, -14, 0},
          {5.7, -1.7, 1.4, -80, -16, 0},  {5.7, -2.4, 1.4, -30, -16, 0},  {5.6, -2.8, 1.4, -100, -16, 0},
          {5.2, -2.9, 1.4, -160, -16, 0}, {5.2, -2.2, 1.4, -200, -14, 0}, {5.6, -1.6, 1.4, -250, -12, 0},
          {5.6, -0.5, 1.4, -250, -12, 0}, {5.0, 0.0, 1.4, -200, -12, 0},  {3.4, 0.0, 1.4, -180, -12, 0},
          {1.8, 0.0, 1.4, -190, -12, 0},  {1.0, 0.1, 1.4, -230, -12, 0},  {0.9, 0.0, 1.4, -360, -12, 0},
          {1.6, 0.05, 1.4, -335, -12, 0}, {2.0, 0.3, 1.4, -290, -13, 0}};
}

}  // namespace

BuiltinScene make_rooms_scene() {
  SceneBuilder b;
  build_shell(b);
  furnish_corridor(b);
  furnish_living_room(b);
  furnish_bedroom(b);
  furnish_study(b);
  BuiltinScene s{b.finish(), tour(), {}};
  s.pace.speed_mps = 0.65;
  s.pace.turn_rate_dps = 45.0;
  return s;
}

}  // namespace loopsift
