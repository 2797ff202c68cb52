// SPDX-License-Identifier: MIT
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>

#include "drivers/synth/mesh_io.hpp"

namespace loopsift {
namespace {

Error at_line(const std::string& path, int line, const std::string& what) {
  return {ErrorCode::kFormat, path + ":" + std::to_string(line) + ": " + what};
}

/// The vertex number in front of the first slash, made zero-based; −1 where there is none in range.
int vertex_index(const std::string& token, std::size_t vertex_count) {
  int index = 0;
  const char* end = token.data() + std::min(token.find('/'), token.size());
  const auto parsed = std::from_chars(token.data(), end, index);
  if (parsed.ec != std::errc() || parsed.ptr != end) return -1;
  const auto count = static_cast<int>(vertex_count);
  if (index < 0) index += count + 1;
  return index >= 1 && index <= count ? index - 1 : -1;
}

Status add_face(std::istringstream& fields, const std::string& path, int line, TriangleMesh* mesh) {
  std::string token;
  int corners = 0, first = 0, previous = 0;
  while (fields >> token) {
    const int index = vertex_index(token, mesh->vertices.size());
    if (index < 0)
      return at_line(path, line,
                     "'" + token + "' names none of the " + std::to_string(mesh->vertices.size()) +
                         " vertices before it");
    if (corners == 0) first = index;
    if (corners >= 2) mesh->triangles.emplace_back(first, previous, index);
    previous = index;
    ++corners;
  }
  if (corners < 3) return at_line(path, line, "a face needs at least three vertices");
  return {};
}

}  // namespace

Expected<TriangleMesh> read_obj(const std::string& path) {
  std::ifstream file(path);
  if (!file) return Error{ErrorCode::kNotFound, path + ": cannot be opened; give the path of an OBJ file"};
  TriangleMesh mesh;
  std::string text;
  for (int line = 1; std::getline(file, text); ++line) {
    std::istringstream fields(text);
    std::string keyword;
    fields >> keyword;
    if (keyword == "v") {
      Eigen::Vector3f p;
      if (!(fields >> p.x() >> p.y() >> p.z()) || !p.allFinite())
        return at_line(path, line, "a vertex needs three finite numbers");
      mesh.vertices.push_back(p);
    } else if (keyword == "f") {
      if (Status s = add_face(fields, path, line, &mesh); !s) return s.error();
    }
  }
  if (mesh.triangles.empty()) return Error{ErrorCode::kFormat, path + ": holds no faces ('f' lines)"};
  return mesh;
}

}  // namespace loopsift
