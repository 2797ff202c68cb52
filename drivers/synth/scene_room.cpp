// SPDX-License-Identifier: MIT
// The furnished room, walked round twice.
#include <cmath>

#include "drivers/synth/builtin_scenes.hpp"
#include "drivers/synth/furniture.hpp"

namespace loopsift {
namespace {

constexpr float kLength = 6.0F, kWidth = 5.0F, kHeight = 2.6F;

const Material kFloor{{0.62F, 0.48F, 0.34F}, {0.42F, 0.3F, 0.2F}, Pattern::kWood, 1.2F};
const Material kCeiling{{0.9F, 0.9F, 0.88F}, {0.75F, 0.75F, 0.74F}, Pattern::kMottled, 1.0F};
const Material kWallpaper{{0.8F, 0.77F, 0.68F}, {0.55F, 0.56F, 0.5F}, Pattern::kMottled, 0.9F};
const Material kWallpaper2{{0.66F, 0.73F, 0.76F}, {0.45F, 0.5F, 0.58F}, Pattern::kStripes, 1.1F};

void build_shell(SceneBuilder& b) {
  add_floor_and_ceiling(b, 0, 0, kLength, kWidth, kHeight, kFloor, kCeiling);
  add_wall(b, 0, 0, kLength, 0, kHeight, kWallpaper);
  add_wall(b, kLength, 0, kLength, kWidth, kHeight, kWallpaper2);
  add_wall(b, kLength, kWidth, 0, kWidth, kHeight, kWallpaper);
  add_wall(b, 0, kWidth, 0, 0, kHeight, kWallpaper2);
  b.place({});
  b.box({1.5F, 1.3F, 0}, {4.6F, 3.5F, 0.01F},
        {{0.6F, 0.25F, 0.22F}, {0.85F, 0.75F, 0.55F}, Pattern::kPicture, 1.5F});  // the rug
}

void furnish_south_and_east(SceneBuilder& b) {
  const auto at = [&](float x, float y, float z, float yaw) { b.place({x, y, z, yaw}); };
  at(0.95F, 0.06F, 0, 0), add_bookshelf(b, 1.2F, 2.0F, 3);
  at(2.75F, 0.08F, 0, 0), add_sofa(b, 1.9F, 5);
  at(2.45F, 0.05F, 1.25F, 0), add_picture(b, 0.8F, 0.6F, 8);
  at(3.35F, 0.05F, 1.4F, 0), add_picture(b, 0.4F, 0.5F, 12);
  at(4.1F, 0.1F, 0, 0), add_floor_lamp(b, 6);
  at(5.1F, 0.06F, 0, 0), add_cupboard(b, 1.0F, 0.45F, 1.1F, 14);
  at(5.1F, 0.1F, 1.13F, 0), add_clutter(b, 0.9F, 0.3F, 9, 9);
  at(5.1F, 0.05F, 1.6F, 0), add_picture(b, 0.7F, 0.45F, 21);
  at(5.94F, 1.6F, 0, 90), add_desk(b, 1.4F, 4);
  at(5.2F, 1.75F, 0, -70), add_chair(b, 33);
  at(5.95F, 1.5F, 1.45F, 90), add_picture(b, 0.9F, 0.5F, 17);
  at(5.94F, 3.0F, 0, 90), add_bookshelf(b, 0.8F, 1.5F, 27);
  at(5.8F, 3.0F, 1.5F, 90), add_clutter(b, 0.6F, 0.15F, 5, 44);
  at(5.9F, 4.1F, 0, 90), add_plant(b, 1.5F, 2);
}

void furnish_north_and_west(SceneBuilder& b) {
  const auto at = [&](float x, float y, float z, float yaw) { b.place({x, y, z, yaw}); };
  at(4.2F, 4.95F, 0, 180), add_window(b, 1.5F, 41);
  at(2.1F, 4.94F, 0, 180), add_cupboard(b, 1.5F, 0.42F, 0.8F, 18);
  at(2.1F, 4.9F, 0.83F, 180), add_clutter(b, 1.3F, 0.3F, 12, 19);
  at(2.4F, 4.95F, 1.35F, 180), add_picture(b, 1.0F, 0.7F, 23);
  at(1.4F, 4.95F, 1.5F, 180), add_picture(b, 0.35F, 0.35F, 25);
  at(0.55F, 4.9F, 0, 180), add_crates(b, 8);
  at(0.05F, 3.9F, 0, -90), add_door(b, 31);
  at(0.06F, 2.4F, 0, -90), add_cupboard(b, 0.9F, 0.5F, 2.05F, 37);
  at(0.3F, 2.4F, 2.08F, -90), add_clutter(b, 0.8F, 0.2F, 4, 38);
  at(0.08F, 1.25F, 0, -90), add_chair(b, 51);
  at(0.05F, 1.2F, 1.35F, -90), add_picture(b, 0.6F, 0.8F, 29);
}

void furnish_middle(SceneBuilder& b) {
  b.place({3.2F, 2.0F, 0, 15});
  add_table(b, 1.5F, 0.85F, 0.74F, 61);
  b.place({3.15F, 2.15F, 0.74F, 15});
  add_clutter(b, 1.2F, 0.5F, 11, 62);
  b.place({2.8F, 1.55F, 0, 25}), add_chair(b, 63);
  b.place({3.75F, 1.75F, 0, 5}), add_chair(b, 63);
  b.place({2.75F, 3.2F, 0, 190}), add_chair(b, 63);
  b.place({4.35F, 2.65F, 0, 110}), add_chair(b, 63);
}

/// Two rounds on an ellipse; the look swings between the walls on the right and the table on the left.
std::vector<Waypoint> two_rounds() {
  constexpr int kSteps = 48;
  constexpr double kTurn = 2.0 * 3.14159265358979;
  std::vector<Waypoint> waypoints;
  for (int i = 0; i <= 2 * kSteps + 6; ++i) {
    const double angle = kTurn * i / kSteps;
    const double wide =
        i > kSteps ? 0.92 : 1.0;  // the second round is a little narrower and looks up a little
    const double travel = angle + 0.25 * kTurn;
    const double look = travel - 0.30 + 0.85 * std::sin(2.0 * angle + 0.6) - (i > kSteps ? 0.08 : 0.0);
    waypoints.push_back({3.0 + 1.55 * wide * std::cos(angle), 2.5 + 1.15 * wide * std::sin(angle),
                         1.38 + 0.08 * std::sin(3.0 * angle), look * 360.0 / kTurn,
                         -16.0 + 7.0 * std::sin(3.0 * angle + 1.0) + (i > kSteps ? 2.0 : 0.0), 0.0});
  }
  return waypoints;
}

}  // namespace

BuiltinScene make_room_scene() {
  SceneBuilder b;
  build_shell(b);
  furnish_south_and_east(b);
  furnish_north_and_west(b);
  furnish_middle(b);
  BuiltinScene s{b.finish(), two_rounds(), {}};
  s.pace.speed_mps = 0.55;
  s.pace.turn_rate_dps = 44.0;
  return s;
}

}  // namespace loopsift
