// SPDX-License-Identifier: MIT
#include "core/base/text_file.hpp"
#include "drivers/synth/mesh_io.hpp"

namespace loopsift {
namespace {

/// The vertex number in front of the first slash, made zero-based; −1 where there is none in range.
int vertex_index(std::string_view word, std::size_t vertex_count) {
  int index = 0;
  if (!parse_number(word.substr(0, word.find('/')), &index)) return -1;
  const auto count = static_cast<int>(vertex_count);
  if (index < 0) index += count + 1;
  return index >= 1 && index <= count ? index - 1 : -1;
}

Status add_vertex(const TextFile& file, TriangleMesh* mesh) {
  Eigen::Vector3d p;
  if (file.words().size() < 4 || !parse_number(file.words()[1], &p.x()) ||
      !parse_number(file.words()[2], &p.y()) || !parse_number(file.words()[3], &p.z()))
    return file.error("a vertex needs three finite numbers");
  mesh->vertices.push_back(p.cast<float>());
  return {};
}

Status add_face(const TextFile& file, TriangleMesh* mesh) {
  if (file.words().size() < 4) return file.error("a face needs at least three vertices");
  int first = 0, previous = 0;
  for (std::size_t k = 1; k < file.words().size(); ++k) {
    const int index = vertex_index(file.words()[k], mesh->vertices.size());
    if (index < 0)
      return file.error("'" + std::string(file.words()[k]) + "' names none of the " +
                        std::to_string(mesh->vertices.size()) + " vertices before it");
    if (k == 1) first = index;
    if (k >= 3) mesh->triangles.emplace_back(first, previous, index);
    previous = index;
  }
  return {};
}

}  // namespace

Expected<TriangleMesh> read_obj(const std::string& path) {
  auto file = TextFile::open(path);
  if (!file) return file.error();
  TriangleMesh mesh;
  while (file->next()) {
    const std::string_view keyword = file->words().front();
    Status status;
    if (keyword == "v") status = add_vertex(*file, &mesh);
    if (keyword == "f") status = add_face(*file, &mesh);
    if (!status) return status.error();
  }
  if (mesh.triangles.empty()) return Error{ErrorCode::kFormat, path + ": holds no faces ('f' lines)"};
  return mesh;
}

}  // namespace loopsift
