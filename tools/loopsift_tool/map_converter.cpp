// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/map_converter.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

namespace loopsift::tool {
namespace {

struct Property {
  std::string type, name;
  std::size_t offset = 0, size = 0;
  bool kept = true;
};

struct Header {
  std::vector<std::string> comments;
  std::vector<Property> properties;
  std::size_t vertices = 0, stride = 0;
};

std::size_t size_of(const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" ||
      type == "float32")
    return 4;
  return type == "double" || type == "float64" ? 8 : 0;
}

Error format_error(const std::string& path, const std::string& what) {
  return {ErrorCode::kFormat, path + ": " + what};
}

bool is_normal(const std::string& name) { return name == "nx" || name == "ny" || name == "nz"; }

Expected<Header> read_header(const std::string& path, std::istream& in, bool drop_normals) {
  Header header;
  std::string line, element;
  if (!std::getline(in, line) || line != "ply") return format_error(path, "is not a PLY file");
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key, value;
    words >> key >> value;
    if (key == "end_header") return header;
    if (key == "comment") header.comments.push_back(line);
    if (key == "format" && value != "binary_little_endian")
      return format_error(path, "is in format '" + value + "'; binary_little_endian can be converted");
    if (key == "element") {
      element = value;
      if (value == "vertex") words >> header.vertices;
      if (value != "vertex" && header.properties.empty())
        return format_error(path, "does not begin with its vertices but with '" + value + "'");
    }
    if (key != "property" || element != "vertex") continue;
    Property property{value, "", header.stride, size_of(value), true};
    words >> property.name;
    if (property.size == 0)
      return format_error(
          path, "vertex property '" + property.name + "' is a '" + value + "', which points do not have");
    property.kept = !(drop_normals && is_normal(property.name));
    header.stride += property.size;
    header.properties.push_back(property);
  }
  return format_error(path, "ends within its header");
}

void write_header(const Header& header, bool text, std::ostream& out) {
  out << "ply\nformat " << (text ? "ascii" : "binary_little_endian") << " 1.0\n";
  for (const std::string& comment : header.comments) out << comment << '\n';
  out << "element vertex " << header.vertices << '\n';
  for (const Property& p : header.properties)
    if (p.kept) out << "property " << p.type << ' ' << p.name << '\n';
  out << "end_header\n";
}

template <class T>
T load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

void print(const Property& p, const char* bytes, std::ostream& out) {
  const bool is_unsigned = p.type[0] == 'u', real = p.type[0] == 'f' || p.type[0] == 'd';
  if (real && p.size == 4)
    out << load<float>(bytes);
  else if (real)
    out << load<double>(bytes);
  else if (p.size == 1)
    out << (is_unsigned ? int{load<std::uint8_t>(bytes)} : int{load<std::int8_t>(bytes)});
  else if (p.size == 2)
    out << (is_unsigned ? int{load<std::uint16_t>(bytes)} : int{load<std::int16_t>(bytes)});
  else
    out << (is_unsigned ? std::int64_t{load<std::uint32_t>(bytes)} : std::int64_t{load<std::int32_t>(bytes)});
}

void write_vertex(const Header& header, const char* bytes, bool text, std::ostream& out) {
  const char* separator = "";
  for (const Property& p : header.properties) {
    if (!p.kept) continue;
    if (text) {
      out << separator;
      print(p, bytes + p.offset, out);
      separator = " ";
    } else {
      out.write(bytes + p.offset, static_cast<std::streamsize>(p.size));
    }
  }
  if (text) out << '\n';
}

}  // namespace

Expected<std::size_t> convert_map(const std::string& from, const std::string& to,
                                  const MapConversion& conversion) {
  std::ifstream in(from, std::ios::binary);
  if (!in) return Error{ErrorCode::kNotFound, from + ": cannot be opened; check the path"};
  const auto header = read_header(from, in, conversion.drop_normals);
  if (!header.ok()) return header.error();
  std::ofstream out(to, std::ios::binary);
  out.precision(9);
  write_header(*header, conversion.text, out);
  std::vector<char> vertex(header->stride);
  for (std::size_t k = 0; k < header->vertices; ++k) {
    if (!in.read(vertex.data(), static_cast<std::streamsize>(vertex.size())))
      return format_error(from, "holds " + std::to_string(k) + " of the " + std::to_string(header->vertices) +
                                    " vertices that its header promises; it is truncated");
    write_vertex(*header, vertex.data(), conversion.text, out);
  }
  out.flush();
  if (!out)
    return Error{ErrorCode::kIo, to + ": cannot be written; check the folder's rights and free space"};
  return header->vertices;
}

}  // namespace loopsift::tool
