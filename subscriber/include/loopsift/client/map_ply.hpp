// SPDX-License-Identifier: MIT
// A rebuilt map as a file: the same bytes as the map.ply that the program saves for the same graph.
#pragma once
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "loopsift/client/map.hpp"

namespace loopsift::client {

/// Binary PLY; axes x right, y down, z forward. False when the file cannot be written.
[[nodiscard]] inline bool write_ply(const std::string& path, const Map& map) {
  std::vector<std::size_t> counts(map.graph().fragments.size());
  std::vector<unsigned char> body;
  map.for_each_surfel_of_all_pieces([&](const Surfel& s, std::int32_t fragment) {
    ++counts[static_cast<std::size_t>(fragment)];
    const float geometry[6] = {-s.y, -s.z, s.x, -s.ny, -s.nz, s.nx};
    const unsigned char color[3] = {s.red, s.green, s.blue};
    const float rest[2] = {s.radius, s.confidence};
    const std::size_t at = body.size();
    body.resize(at + sizeof geometry + sizeof color + sizeof rest);
    std::memcpy(&body[at], geometry, sizeof geometry);
    std::memcpy(&body[at + sizeof geometry], color, sizeof color);
    std::memcpy(&body[at + sizeof geometry + sizeof color], rest, sizeof rest);
  });
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  std::fputs(
      "ply\nformat binary_little_endian 1.0\n"
      "comment surfels: metres in the map frame; radius in metres; confidence is accumulated weight\n",
      file);
  std::size_t all = 0;
  for (std::size_t f = 0; f < counts.size(); ++f) {
    std::fprintf(file, "comment fragment %zu surfels %zu first_frame_s %.9f\n", f, counts[f],
                 static_cast<double>(map.graph().fragments[f].first_frame_ns) * 1e-9);
    all += counts[f];
  }
  std::fprintf(file,
               "element vertex %zu\n"
               "property float x\nproperty float y\nproperty float z\n"
               "property float nx\nproperty float ny\nproperty float nz\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\n"
               "property float radius\nproperty float confidence\nend_header\n",
               all);
  std::fwrite(body.data(), 1, body.size(), file);
  const bool failed = std::ferror(file) != 0;
  return std::fclose(file) == 0 && !failed;
}

}  // namespace loopsift::client
