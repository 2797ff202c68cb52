// SPDX-License-Identifier: MIT
#include "core/fragment/surfel_ply.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace loopsift {
namespace {

constexpr std::size_t kVertexBytes = 8 * sizeof(float) + 3;
constexpr std::size_t kBufferedVertices = 4096;

struct FileCloser {
  void operator()(std::FILE* f) const { std::fclose(f); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

Error io_error(const std::string& path, const char* what) {
  return {ErrorCode::kIo, path + ": " + what + ": " + std::strerror(errno)};
}

bool write_fragment_comments(std::FILE* file, Span<const Fragment> fragments) {
  for (const Fragment& fragment : fragments) {
    const std::int64_t first_ns = fragment.frames.empty() ? 0 : fragment.frames[0].timestamp_ns;
    if (std::fprintf(file, "comment fragment %d surfels %zu first_frame_s %.9f\n", fragment.id.value,
                     fragment.surfels.size(), static_cast<double>(first_ns) * 1e-9) < 0)
      return false;
  }
  return true;
}

bool write_header(std::FILE* file, Span<const Fragment> fragments) {
  std::size_t count = 0;
  for (const Fragment& fragment : fragments) count += fragment.surfels.size();
  return std::fputs(
             "ply\nformat binary_little_endian 1.0\n"
             "comment surfels: metres in the map frame; radius in metres; confidence is accumulated weight\n",
             file) >= 0 &&
         write_fragment_comments(file, fragments) &&
         std::fprintf(file,
                      "element vertex %zu\n"
                      "property float x\nproperty float y\nproperty float z\n"
                      "property float nx\nproperty float ny\nproperty float nz\n"
                      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                      "property float radius\nproperty float confidence\nend_header\n",
                      count) > 0;
}

void encode(const SurfelSpan& s, std::size_t i, const Se3f& T, unsigned char* out) {
  const Eigen::Vector3f p = T * Eigen::Vector3f(s.x[i], s.y[i], s.z[i]);
  const Eigen::Vector3f n = T.R * Eigen::Vector3f(s.nx[i], s.ny[i], s.nz[i]);
  const float geometry[6] = {p.x(), p.y(), p.z(), n.x(), n.y(), n.z()};
  std::memcpy(out, geometry, sizeof geometry);
  out += sizeof geometry;
  for (const int shift : {16, 8, 0}) *out++ = static_cast<unsigned char>(s.rgb[i] >> shift & 0xFFU);
  const float rest[2] = {s.radius[i], s.weight[i]};
  std::memcpy(out, rest, sizeof rest);
}

bool write_surfels(std::FILE* file, const SurfelSpan& surfels, const Se3f& T, unsigned char* buffer) {
  for (std::size_t begin = 0; begin < surfels.size(); begin += kBufferedVertices) {
    const std::size_t count = std::min(kBufferedVertices, surfels.size() - begin);
    for (std::size_t i = 0; i < count; ++i) encode(surfels, begin + i, T, buffer + i * kVertexBytes);
    if (std::fwrite(buffer, kVertexBytes, count, file) != count) return false;
  }
  return true;
}

}  // namespace

Status write_surfel_ply(const std::string& path, Span<const Fragment> fragments,
                        Span<const Se3> T_map_fragment) {
  if (fragments.size() != T_map_fragment.size())
    return Error{ErrorCode::kUsage, path + ": a map needs one pose per fragment, got " +
                                        std::to_string(T_map_fragment.size()) + " poses for " +
                                        std::to_string(fragments.size()) + " fragments"};
  File file(std::fopen(path.c_str(), "wb"));
  if (!file) return io_error(path, "cannot be created");
  bool ok = write_header(file.get(), fragments);
  const auto buffer = std::make_unique<unsigned char[]>(kBufferedVertices * kVertexBytes);
  for (std::size_t f = 0; ok && f < fragments.size(); ++f)
    ok = write_surfels(file.get(), fragments[f].surfels, Se3f(T_map_fragment[f]), buffer.get());
  if (!ok || std::fclose(file.release()) != 0)
    return io_error(path, "could not be written completely (is the disk full?)");
  return {};
}

}  // namespace loopsift
