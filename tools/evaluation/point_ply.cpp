// SPDX-License-Identifier: MIT
#include "tools/evaluation/point_ply.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

namespace loopsift {
namespace {

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct ScalarName {
  const char* name;
  Scalar type;
  std::size_t size;
};

constexpr ScalarName kScalars[] = {
    {"char", Scalar::kInt8, 1},     {"int8", Scalar::kInt8, 1},     {"uchar", Scalar::kUint8, 1},
    {"uint8", Scalar::kUint8, 1},   {"short", Scalar::kInt16, 2},   {"int16", Scalar::kInt16, 2},
    {"ushort", Scalar::kUint16, 2}, {"uint16", Scalar::kUint16, 2}, {"int", Scalar::kInt32, 4},
    {"int32", Scalar::kInt32, 4},   {"uint", Scalar::kUint32, 4},   {"uint32", Scalar::kUint32, 4},
    {"float", Scalar::kFloat, 4},   {"float32", Scalar::kFloat, 4}, {"double", Scalar::kDouble, 8},
    {"float64", Scalar::kDouble, 8}};

struct Property {
  std::string name;
  const ScalarName* scalar;
  std::size_t offset;  // bytes from the start of a binary vertex
};

struct Header {
  bool binary = false;
  std::size_t vertices = 0;
  std::size_t stride = 0;  // bytes of a binary vertex
  std::vector<Property> properties;
  std::array<std::size_t, 3> xyz{};  // indices into properties
};

Error format_error(const std::string& path, const std::string& what) {
  return {ErrorCode::kFormat, path + ": " + what};
}

/// One property line of the vertex element.
Status add_property(const std::string& path, std::istream& words, Header* header) {
  std::string type, name;
  words >> type >> name;
  const auto* scalar = std::find_if(std::begin(kScalars), std::end(kScalars),
                                    [&](const ScalarName& s) { return type == s.name; });
  if (scalar == std::end(kScalars))
    return format_error(
        path, "vertex property '" + name + "' has the type '" + type + "', which points do not have");
  header->properties.push_back({name, scalar, header->stride});
  header->stride += scalar->size;
  return {};
}

Status find_xyz(const std::string& path, Header* header) {
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto found = std::find_if(header->properties.begin(), header->properties.end(),
                                    [&](const Property& p) { return p.name == kNames[k]; });
    if (found == header->properties.end())
      return format_error(path, std::string("its vertices have no property '") + kNames[k] + "'");
    header->xyz[k] = static_cast<std::size_t>(found - header->properties.begin());
  }
  return {};
}

Expected<Header> read_header(const std::string& path, std::istream& in) {
  Header header;
  std::string line, element;
  if (!std::getline(in, line) || line.rfind("ply", 0) != 0) return format_error(path, "is not a PLY file");
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key, value;
    words >> key;
    if (key == "end_header") {
      if (const Status status = find_xyz(path, &header); !status.ok()) return status.error();
      return header;
    }
    if (key == "format") {
      words >> value;
      if (value != "ascii" && value != "binary_little_endian")
        return format_error(path, "is in format '" + value + "'; ascii and binary_little_endian can be read");
      header.binary = value != "ascii";
    } else if (key == "element") {
      words >> element;
      if (element == "vertex") words >> header.vertices;
      if (element != "vertex" && header.properties.empty())
        return format_error(path, "does not begin with its vertices but with '" + element + "'");
    } else if (key == "property" && element == "vertex") {
      if (const Status status = add_property(path, words, &header); !status.ok()) return status.error();
    }
  }
  return format_error(path, "ends within its header");
}

template <class T>
float load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<float>(value);
}

float load(Scalar type, const char* bytes) {
  switch (type) {
    case Scalar::kInt8:
      return load<std::int8_t>(bytes);
    case Scalar::kUint8:
      return load<std::uint8_t>(bytes);
    case Scalar::kInt16:
      return load<std::int16_t>(bytes);
    case Scalar::kUint16:
      return load<std::uint16_t>(bytes);
    case Scalar::kInt32:
      return load<std::int32_t>(bytes);
    case Scalar::kUint32:
      return load<std::uint32_t>(bytes);
    case Scalar::kFloat:
      return load<float>(bytes);
    case Scalar::kDouble:
      return load<double>(bytes);
  }
  return 0;
}

/// The next vertex; false at the end of the file.
bool read_vertex(const Header& header, std::istream& in, std::vector<char>* bytes, std::vector<float>* values,
                 Eigen::Vector3f* point) {
  if (header.binary) {
    if (!in.read(bytes->data(), static_cast<std::streamsize>(header.stride))) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Property& p = header.properties[header.xyz[k]];
      (*point)[static_cast<Eigen::Index>(k)] = load(p.scalar->type, bytes->data() + p.offset);
    }
    return true;
  }
  for (float& value : *values)
    if (!(in >> value)) return false;
  for (std::size_t k = 0; k < 3; ++k) (*point)[static_cast<Eigen::Index>(k)] = (*values)[header.xyz[k]];
  return true;
}

}  // namespace

Expected<std::vector<Eigen::Vector3f>> read_ply_points(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened; check the path"};
  const auto header = read_header(path, in);
  if (!header.ok()) return header.error();
  std::vector<char> bytes(header->stride);
  std::vector<float> values(header->properties.size());
  std::vector<Eigen::Vector3f> points;
  for (std::size_t k = 0; k < header->vertices; ++k) {
    Eigen::Vector3f point;
    if (!read_vertex(*header, in, &bytes, &values, &point))
      return format_error(path, "holds " + std::to_string(k) + " of the " + std::to_string(header->vertices) +
                                    " vertices that its header promises; it is truncated");
    if (!point.allFinite()) return format_error(path, "vertex " + std::to_string(k) + " is not finite");
    points.push_back(point);
  }
  return points;
}

Expected<std::vector<double>> read_fragment_times(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened; check the path"};
  std::string line;
  if (!std::getline(in, line) || line.rfind("ply", 0) != 0) return format_error(path, "is not a PLY file");
  std::vector<double> times;
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    std::string comment, fragment, surfels, first_frame;
    std::size_t id = 0, count = 0;
    double time_s = 0;
    if (words >> comment >> fragment >> id >> surfels >> count >> first_frame >> time_s &&
        comment == "comment" && fragment == "fragment" && first_frame == "first_frame_s" &&
        id == times.size())
      times.push_back(time_s);
  }
  return times;
}

}  // namespace loopsift
