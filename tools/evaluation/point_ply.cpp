// SPDX-License-Identifier: MIT
#include "tools/evaluation/point_ply.hpp"

#include <algorithm>
#include <cmath>
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
  std::vector<std::size_t> wanted;  // indices into properties
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

Status find(const std::string& path, const std::vector<std::string>& names, Header* header) {
  for (const std::string& name : names) {
    const auto found = std::find_if(header->properties.begin(), header->properties.end(),
                                    [&](const Property& p) { return p.name == name; });
    if (found == header->properties.end())
      return format_error(path, "its vertices have no property '" + name + "'");
    header->wanted.push_back(static_cast<std::size_t>(found - header->properties.begin()));
  }
  return {};
}

Expected<Header> read_header(const std::string& path, const std::vector<std::string>& names,
                             std::istream& in) {
  Header header;
  std::string line, element;
  if (!std::getline(in, line) || line.rfind("ply", 0) != 0) return format_error(path, "is not a PLY file");
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key, value;
    words >> key;
    if (key == "end_header") {
      if (const Status status = find(path, names, &header); !status.ok()) return status.error();
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

/// The next vertex's wanted values; false at the end of the file.
bool read_vertex(const Header& header, std::istream& in, std::vector<char>* bytes, std::vector<float>* values,
                 std::vector<float>* wanted) {
  if (header.binary) {
    if (!in.read(bytes->data(), static_cast<std::streamsize>(header.stride))) return false;
    for (std::size_t k = 0; k < wanted->size(); ++k) {
      const Property& p = header.properties[header.wanted[k]];
      (*wanted)[k] = load(p.scalar->type, bytes->data() + p.offset);
    }
    return true;
  }
  for (float& value : *values)
    if (!(in >> value)) return false;
  for (std::size_t k = 0; k < wanted->size(); ++k) (*wanted)[k] = (*values)[header.wanted[k]];
  return true;
}

/// Calls take(values) for each vertex.
template <class Take>
Status for_each_vertex(const std::string& path, const std::vector<std::string>& names, const Take& take) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened; check the path"};
  const auto header = read_header(path, names, in);
  if (!header.ok()) return header.error();
  std::vector<char> bytes(header->stride);
  std::vector<float> values(header->properties.size()), wanted(names.size());
  for (std::size_t k = 0; k < header->vertices; ++k) {
    if (!read_vertex(*header, in, &bytes, &values, &wanted))
      return format_error(path, "holds " + std::to_string(k) + " of the " + std::to_string(header->vertices) +
                                    " vertices that its header promises; it is truncated");
    if (!std::all_of(wanted.begin(), wanted.end(), [](float v) { return std::isfinite(v); }))
      return format_error(path, "vertex " + std::to_string(k) + " is not finite");
    take(wanted);
  }
  return {};
}

}  // namespace

Expected<std::vector<Eigen::Vector3f>> read_ply_points(const std::string& path) {
  std::vector<Eigen::Vector3f> points;
  const Status read = for_each_vertex(
      path, {"x", "y", "z"}, [&](const std::vector<float>& v) { points.emplace_back(v[0], v[1], v[2]); });
  if (!read) return read.error();
  return points;
}

Expected<std::vector<std::vector<float>>> read_ply_columns(const std::string& path,
                                                           const std::vector<std::string>& names) {
  std::vector<std::vector<float>> columns(names.size());
  const Status read = for_each_vertex(path, names, [&](const std::vector<float>& v) {
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].push_back(v[c]);
  });
  if (!read) return read.error();
  return columns;
}

Expected<std::vector<PlyFragment>> read_ply_fragments(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened; check the path"};
  std::string line;
  if (!std::getline(in, line) || line.rfind("ply", 0) != 0) return format_error(path, "is not a PLY file");
  std::vector<PlyFragment> fragments;
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    std::string comment, fragment, surfels, first_frame;
    std::size_t id = 0, count = 0;
    double time_s = 0;
    if (words >> comment >> fragment >> id >> surfels >> count >> first_frame >> time_s &&
        comment == "comment" && fragment == "fragment" && first_frame == "first_frame_s" &&
        id == fragments.size())
      fragments.push_back({time_s, count});
  }
  return fragments;
}

}  // namespace loopsift
