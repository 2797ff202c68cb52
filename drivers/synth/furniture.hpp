// SPDX-License-Identifier: MIT
// Furniture of the built-in scenes. Every object is built in the builder's current placement: the origin on
// the floor in the middle of the object's back, x to the right seen from behind, y to the front, z up;
// metres. The number `look` picks colours and the arrangement of small things; equal numbers give equal
// objects.
#pragma once
#include <cstdint>
#include <vector>

#include "drivers/synth/scene.hpp"

namespace loopsift {

/// An open doorway in a wall.
struct Opening {
  float from = 0, to = 0;  ///< metres along the wall from its first end
  float height = 2.05F;
};

void add_wall(SceneBuilder& b, float x0, float y0, float x1, float y1, float height, const Material& material,
              const std::vector<Opening>& openings = {});
/// Floor and ceiling of a rectangle.
void add_floor_and_ceiling(SceneBuilder& b, float x0, float y0, float x1, float y1, float height,
                           const Material& floor, const Material& ceiling);

void add_table(SceneBuilder& b, float width, float depth, float height, std::uint64_t look);
void add_chair(SceneBuilder& b, std::uint64_t look);
void add_bookshelf(SceneBuilder& b, float width, float height, std::uint64_t look);
void add_cupboard(SceneBuilder& b, float width, float depth, float height, std::uint64_t look);
void add_sofa(SceneBuilder& b, float width, std::uint64_t look);
void add_bed(SceneBuilder& b, float width, float length, std::uint64_t look);
void add_floor_lamp(SceneBuilder& b, std::uint64_t look);
/// Hangs on a wall with its lower edge at the placement's height.
void add_picture(SceneBuilder& b, float width, float height, std::uint64_t look);
void add_plant(SceneBuilder& b, float height, std::uint64_t look);
/// A desk with a monitor, a keyboard, a mug and papers.
void add_desk(SceneBuilder& b, float width, std::uint64_t look);
/// A window with frame, curtains and a radiator below.
void add_window(SceneBuilder& b, float width, std::uint64_t look);
/// A door leaf with frame and handle, closed.
void add_door(SceneBuilder& b, std::uint64_t look);
/// Three boxes piled up, each turned a little.
void add_crates(SceneBuilder& b, std::uint64_t look);
/// Small boxes, cylinders and balls on a rectangle width × depth at the placement's height.
void add_clutter(SceneBuilder& b, float width, float depth, int count, std::uint64_t look);

}  // namespace loopsift
