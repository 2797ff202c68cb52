// SPDX-License-Identifier: MIT
// Mesh files. Desk and set-up code: allocates. Errors name the file, the line (text) or the element (binary)
// and what is wrong with it.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "drivers/synth/mesh.hpp"

namespace loopsift {

/// Reads an OBJ or a PLY, told apart by the file name's ending.
[[nodiscard]] Expected<TriangleMesh> read_mesh(const std::string& path);

/// Wavefront OBJ: `v x y z` and `f` with any of the forms i, i/t, i//n, i/t/n; negative indices count from
/// the end; polygons are cut into fans. Every other record is passed over.
[[nodiscard]] Expected<TriangleMesh> read_obj(const std::string& path);

/// PLY, ascii or binary little-endian: elements vertex (x y z, and red green blue as bytes where present) and
/// face (one list of indices; polygons are cut into fans). Other properties and elements are passed over.
[[nodiscard]] Expected<TriangleMesh> read_ply(const std::string& path);

/// Binary little-endian PLY with float positions, colours where the mesh has them, and triangles.
[[nodiscard]] Status write_ply(const std::string& path, const TriangleMesh& mesh);

}  // namespace loopsift
