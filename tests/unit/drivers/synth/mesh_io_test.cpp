// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "drivers/synth/mesh_io.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

class MeshFiles : public ::testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }
  test::TemporaryFolder folder_;
};

TEST_F(MeshFiles, ObjWithSlashesNegativeIndicesAndPolygons) {
  const auto mesh = read_mesh(file("a.obj",
                                   "# a square and a triangle\nmtllib none.mtl\n"
                                   "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvn 0 0 1\n"
                                   "f 1/1/1 2//1 3/2 4\n"
                                   "f -4 -3 -1\n"));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->vertices.size(), 4U);
  ASSERT_EQ(mesh->triangles.size(), 3U);
  EXPECT_EQ(mesh->triangles[0], Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh->triangles[1], Eigen::Vector3i(0, 2, 3));
  EXPECT_EQ(mesh->triangles[2], Eigen::Vector3i(0, 1, 3));
  EXPECT_FLOAT_EQ(mesh->vertices[3].z(), 0.5F);
}

TEST_F(MeshFiles, ObjErrorsNameFileAndLine) {
  const auto error = [&](const std::string& text) {
    const auto mesh = read_obj(file("bad.obj", text));
    return mesh.ok() ? std::string("no error") : mesh.error().message;
  };
  EXPECT_THAT(error("v 0 0 0\nv 1 x 0\n"), HasSubstr("bad.obj:2"));
  EXPECT_THAT(error("v 0 0 nan\n"), HasSubstr("bad.obj:1"));
  EXPECT_THAT(error("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n"), HasSubstr("bad.obj:5"));
  EXPECT_THAT(error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n"), HasSubstr("'0'"));
  EXPECT_THAT(error("v 0 0 0\nv 1 0 0\nf 1 2\n"), HasSubstr("bad.obj:3"));
  EXPECT_THAT(error("v 0 0 0\n"), HasSubstr("no faces"));
}

TEST_F(MeshFiles, MissingFileAndUnknownEnding) {
  const auto missing = read_mesh(folder_ / "missing.obj");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("missing.obj"));
  const auto other = read_mesh("scene.stl");
  ASSERT_FALSE(other.ok());
  EXPECT_THAT(other.error().message, HasSubstr("scene.stl"));
}

TEST_F(MeshFiles, PlyRoundTripKeepsEverything) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1.5F, 0, 0}, {0, 2.25F, 0}, {0, 0, -3}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}};
  mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}};
  const std::string path = folder_ / "mesh.ply";
  ASSERT_TRUE(write_ply(path, mesh).ok());
  const auto read = read_mesh(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->vertices, mesh.vertices);
  EXPECT_EQ(read->triangles, mesh.triangles);
  ASSERT_EQ(read->colors.size(), 4U);
  EXPECT_EQ(read->colors[3].b, 128);
}

const char* const kHead =
    "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty float quality\nelement face 1\nproperty list uchar int vertex_indices\n"
    "end_header\n";

TEST_F(MeshFiles, AsciiPlyWithAQuad) {
  const auto mesh =
      read_ply(file("q.ply", std::string(kHead) + "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n4 0 1 2 3\n"));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 2U);
  EXPECT_EQ(mesh->vertices[2], Eigen::Vector3f(1, 1, 0));
}

TEST_F(MeshFiles, PlyErrorsNameFileAndPlace) {
  const auto error = [&](const std::string& text) {
    const auto mesh = read_ply(file("bad.ply", text));
    return mesh.ok() ? std::string("no error") : mesh.error().message;
  };
  EXPECT_THAT(error("play\n"), HasSubstr("bad.ply:1"));
  EXPECT_THAT(error("ply\nformat binary_big_endian 1.0\n"), HasSubstr("bad.ply:2"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty quaternion x\n"),
              HasSubstr("bad.ply:4"));
  EXPECT_THAT(error(std::string(kHead) + "0 0 0 9\n1 0\n"), HasSubstr("bad.ply:13"));
  EXPECT_THAT(error(std::string(kHead) + "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n3 0 1 4\n"),
              HasSubstr("bad.ply:16"));
  EXPECT_THAT(error(std::string(kHead) + "0 0 0 9\n"), HasSubstr("ends before"));
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
  const std::string path = folder_ / "cut.ply";
  ASSERT_TRUE(write_ply(path, mesh).ok());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 5);
  const auto cut = read_ply(path);
  ASSERT_FALSE(cut.ok());
  EXPECT_THAT(cut.error().message, HasSubstr("cut.ply: face 1"));
}

}  // namespace
}  // namespace loopsift
