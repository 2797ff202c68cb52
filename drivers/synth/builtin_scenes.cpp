// SPDX-License-Identifier: MIT
#include "drivers/synth/builtin_scenes.hpp"

#include <array>
#include <cmath>

namespace loopsift {
namespace {

BuiltinScene make_notexture_scene() {
  BuiltinScene s = make_room_scene();
  s.scene.remove_texture();
  s.waypoints.resize(s.waypoints.size() * 3 / 5);
  return s;
}

/// Turning to and fro in the middle of the room while the eye moves on a small circle.
BuiltinScene make_rotation_scene() {
  BuiltinScene s = make_room_scene();
  s.waypoints.clear();
  s.pace.turn_rate_dps = 60.0;
  constexpr std::array<Waypoint, 9> kTurns = {{{2.2, 1.55, 1.35, 20, -10, 0},
                                               {2.0, 1.7, 1.4, 200, -15, 5},
                                               {2.1, 1.9, 1.4, 200, 0, -10},
                                               {2.3, 1.8, 1.35, 90, -30, -10},
                                               {2.2, 1.6, 1.35, 90, -10, 25},
                                               {2.1, 1.6, 1.4, -30, -5, 0},
                                               {2.1, 1.7, 1.45, -30, -35, 0},
                                               {2.3, 1.8, 1.4, 330, -12, 0},
                                               {2.2, 1.55, 1.35, 20, -10, 0}}};
  for (const Waypoint& w : kTurns) s.waypoints.push_back(w);
  return s;
}

struct Entry {
  const char* name;
  BuiltinScene (*make)();
};

constexpr std::array<Entry, 6> kScenes = {{{"corridor", make_corridor_scene},
                                           {"lookalike", make_lookalike_scene},
                                           {"notexture", make_notexture_scene},
                                           {"room", make_room_scene},
                                           {"rooms", make_rooms_scene},
                                           {"rotation", make_rotation_scene}}};

}  // namespace

std::string builtin_scene_names() {
  std::string names;
  for (const Entry& entry : kScenes) names += (names.empty() ? "" : ", ") + std::string(entry.name);
  return names;
}

Expected<BuiltinScene> make_builtin_scene(const std::string& name) {
  for (const Entry& entry : kScenes)
    if (name == entry.name) return entry.make();
  return Error{ErrorCode::kUsage, "synth: no scene '" + name + "'; there are " + builtin_scene_names()};
}

}  // namespace loopsift
