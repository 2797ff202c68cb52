// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include "drivers/synth/mesh_io.hpp"

namespace loopsift {
namespace {

/// A PLY scalar type by its size in bytes, and whether it is a float or signed.
struct Scalar {
  int bytes = 0;
  bool real = false;
  bool is_signed = false;
};

struct Property {
  std::string name;
  Scalar type;
  Scalar count_type;  ///< bytes != 0: a list, whose length has this type
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

bool scalar_of(const std::string& name, Scalar* type) {
  if (name == "char" || name == "int8") return *type = {1, false, true}, true;
  if (name == "uchar" || name == "uint8") return *type = {1, false, false}, true;
  if (name == "short" || name == "int16") return *type = {2, false, true}, true;
  if (name == "ushort" || name == "uint16") return *type = {2, false, false}, true;
  if (name == "int" || name == "int32") return *type = {4, false, true}, true;
  if (name == "uint" || name == "uint32") return *type = {4, false, false}, true;
  if (name == "float" || name == "float32") return *type = {4, true, true}, true;
  if (name == "double" || name == "float64") return *type = {8, true, true}, true;
  return false;
}

template <class T>
double value_of(const char* bytes) {
  T v;
  std::memcpy(&v, bytes, sizeof v);
  return static_cast<double>(v);
}

class PlyReader {
 public:
  explicit PlyReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {}

  Expected<TriangleMesh> read() {
    if (!file_) return Error{ErrorCode::kNotFound, path_ + ": cannot be opened; give the path of a PLY file"};
    if (Status s = read_header(); !s) return s.error();
    for (const Element& element : elements_)
      for (std::int64_t i = 0; i < element.count; ++i)
        if (Status s = read_record(element, i); !s) return s.error();
    if (mesh_.triangles.empty()) return Error{ErrorCode::kFormat, path_ + ": holds no faces"};
    return std::move(mesh_);
  }

 private:
  Status header_error(const std::string& what) const {
    return Error{ErrorCode::kFormat, path_ + ":" + std::to_string(line_) + ": " + what};
  }
  Status record_error(const Element& element, std::int64_t i, const std::string& what) const {
    const std::string place =
        ascii_ ? ":" + std::to_string(line_) : ": " + element.name + " " + std::to_string(i);
    return Error{ErrorCode::kFormat, path_ + place + ": " + what};
  }

  Status read_header() {
    std::string text;
    if (!next_line(&text) || text != "ply") return header_error("a PLY file starts with the line 'ply'");
    while (next_line(&text)) {
      std::istringstream fields(text);
      std::string keyword;
      fields >> keyword;
      if (keyword == "end_header") return {};
      if (keyword == "format") {
        std::string format;
        fields >> format;
        if (format != "ascii" && format != "binary_little_endian")
          return header_error("format '" + format + "' is not read; use ascii or binary_little_endian");
        ascii_ = format == "ascii";
      } else if (keyword == "element") {
        Element element;
        if (!(fields >> element.name >> element.count) || element.count < 0)
          return header_error("expected 'element NAME COUNT'");
        elements_.push_back(element);
      } else if (keyword == "property") {
        if (!add_property(fields)) return header_error("'" + text + "' is no property of a known type");
      }
    }
    return header_error("the header does not end with 'end_header'");
  }

  bool add_property(std::istringstream& fields) {
    if (elements_.empty()) return false;
    Property property;
    std::string type;
    fields >> type;
    if (type == "list") {
      fields >> type;
      if (!scalar_of(type, &property.count_type) || property.count_type.real) return false;
      fields >> type;
    }
    if (!scalar_of(type, &property.type) || !(fields >> property.name)) return false;
    elements_.back().properties.push_back(property);
    return true;
  }

  bool next_line(std::string* text) {
    ++line_;
    if (!std::getline(file_, *text)) return false;
    if (!text->empty() && text->back() == '\r') text->pop_back();
    return true;
  }

  bool read_scalar(const Scalar& type, double* value) {
    if (ascii_) return static_cast<bool>(fields_ >> *value);
    char bytes[8];
    if (!file_.read(bytes, type.bytes)) return false;
    if (type.real)
      *value = type.bytes == 4 ? value_of<float>(bytes) : value_of<double>(bytes);
    else if (type.bytes == 1)
      *value = type.is_signed ? value_of<std::int8_t>(bytes) : value_of<std::uint8_t>(bytes);
    else if (type.bytes == 2)
      *value = type.is_signed ? value_of<std::int16_t>(bytes) : value_of<std::uint16_t>(bytes);
    else
      *value = type.is_signed ? value_of<std::int32_t>(bytes) : value_of<std::uint32_t>(bytes);
    return true;
  }

  Status read_record(const Element& element, std::int64_t i) {
    if (ascii_) {
      std::string text;
      if (!next_line(&text)) return record_error(element, i, "the file ends before its last " + element.name);
      fields_ = std::istringstream(text);
    }
    Eigen::Vector3f p = Eigen::Vector3f::Zero();
    Rgb8 color;
    bool colored = false;
    for (const Property& property : element.properties) {
      if (property.count_type.bytes != 0) {
        if (Status s = read_list(element, property, i); !s) return s;
        continue;
      }
      double value = 0;
      if (!read_scalar(property.type, &value))
        return record_error(element, i, "property '" + property.name + "' is missing");
      if (property.name == "x") p.x() = static_cast<float>(value);
      if (property.name == "y") p.y() = static_cast<float>(value);
      if (property.name == "z") p.z() = static_cast<float>(value);
      colored = colored || property.name == "red";
      if (property.name == "red") color.r = static_cast<unsigned char>(value);
      if (property.name == "green") color.g = static_cast<unsigned char>(value);
      if (property.name == "blue") color.b = static_cast<unsigned char>(value);
    }
    if (element.name != "vertex") return {};
    if (!p.allFinite()) return record_error(element, i, "the position is not finite");
    mesh_.vertices.push_back(p);
    if (colored) mesh_.colors.push_back(color);
    return {};
  }

  Status read_list(const Element& element, const Property& property, std::int64_t i) {
    double count = 0;
    if (!read_scalar(property.count_type, &count) || count < 0)
      return record_error(element, i, "list '" + property.name + "' has no length");
    const bool face = element.name == "face" && property.name.rfind("vertex_ind", 0) == 0;
    if (face && count < 3) return record_error(element, i, "a face needs at least three vertices");
    int first = 0, previous = 0;
    for (int k = 0; k < static_cast<int>(count); ++k) {
      double value = 0;
      if (!read_scalar(property.type, &value))
        return record_error(element, i, "list '" + property.name + "' is cut short");
      if (!face) continue;
      if (!(value >= 0 && value < static_cast<double>(mesh_.vertices.size())))
        return record_error(element, i,
                            "vertex index out of range (" + std::to_string(mesh_.vertices.size()) +
                                " vertices; they must come before the faces)");
      const auto index = static_cast<int>(value);
      if (k == 0) first = index;
      if (k >= 2) mesh_.triangles.emplace_back(first, previous, index);
      previous = index;
    }
    return {};
  }

  std::string path_;
  std::ifstream file_;
  std::istringstream fields_;
  std::vector<Element> elements_;
  TriangleMesh mesh_;
  int line_ = 0;
  bool ascii_ = true;
};

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

template <class T>
void put(std::ofstream& file, const T& value) {
  file.write(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

Expected<TriangleMesh> read_ply(const std::string& path) { return PlyReader(path).read(); }

Expected<TriangleMesh> read_mesh(const std::string& path) {
  if (ends_with(path, ".obj") || ends_with(path, ".OBJ")) return read_obj(path);
  if (ends_with(path, ".ply") || ends_with(path, ".PLY")) return read_ply(path);
  return Error{ErrorCode::kUsage, path + ": a mesh file ends in .obj or .ply"};
}

Status write_ply(const std::string& path, const TriangleMesh& mesh) {
  std::ofstream file(path, std::ios::binary);
  const bool colored = mesh.colors.size() == mesh.vertices.size();
  file << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.size()
       << "\nproperty float x\nproperty float y\nproperty float z\n"
       << (colored ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "")
       << "element face " << mesh.triangles.size()
       << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    put(file, mesh.vertices[i]);
    if (colored) put(file, mesh.colors[i]);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    put(file, static_cast<unsigned char>(3));
    put(file, t);
  }
  file.flush();
  if (!file)
    return Error{ErrorCode::kIo, path + ": cannot be written; check the folder's rights and free space"};
  return {};
}

}  // namespace loopsift
