// SPDX-License-Identifier: MIT
// The scenes that need no files. Each is made to show one thing. Set-up code: allocates.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/synth/path.hpp"
#include "drivers/synth/scene.hpp"

namespace loopsift {

struct BuiltinScene {
  Scene scene;
  std::vector<Waypoint> waypoints;
  Pace pace;
};

/// By name:
///   room       a furnished room, 6 × 5 × 2.6 m, walked round twice: the second round meets the first
///   rooms      three different rooms on a corridor, entered one after the other, back to the start
///   lookalike  a corridor with five equal alcoves (two hold one object more), walked up and down: most loops
///              that look right are wrong, those of the way back are true
///   corridor   almost flat walls with weak texture: motion along it is hardly observable
///   notexture  the room in one plain grey
///   rotation   the room seen from its middle, turning at up to 60 degrees per second
/// Errors: kUsage with the list of names.
[[nodiscard]] Expected<BuiltinScene> make_builtin_scene(const std::string& name);

/// "corridor, lookalike, …", for messages.
[[nodiscard]] std::string builtin_scene_names();

BuiltinScene make_room_scene();
BuiltinScene make_rooms_scene();
BuiltinScene make_lookalike_scene();
BuiltinScene make_corridor_scene();

}  // namespace loopsift
