// SPDX-License-Identifier: MIT
#include "firmware_app/camera_file.hpp"

#include <filesystem>

#include "firmware_app/option_table.hpp"

namespace loopsift {
namespace {

constexpr OptionRange kPixels{0, 1e5}, kSize{0, 8192}, kRadial{-100, 100}, kTangential{-1, 1};

OptionSection lens_section(const char* name, const char* comment, LensCalibration& lens) {
  BrownConrady& d = lens.distortion;
  return {name,
          comment,
          {
              {"width", &lens.camera.width, "of the image that the rest is for, pixels", kSize},
              {"height", &lens.camera.height, "pixels", kSize},
              {"fx", &lens.camera.fx, "focal length, pixels", kPixels},
              {"fy", &lens.camera.fy, "focal length, pixels", kPixels},
              {"cx", &lens.camera.cx, "principal point, pixels, pixel centres at integers", kPixels},
              {"cy", &lens.camera.cy, "principal point, pixels, pixel centres at integers", kPixels},
              {"k1", &d.k1, "radial distortion", kRadial},
              {"k2", &d.k2, "radial distortion", kRadial},
              {"p1", &d.p1, "tangential distortion", kTangential},
              {"p2", &d.p2, "tangential distortion", kTangential},
              {"k3", &d.k3, "radial distortion", kRadial},
              {"mirrored", &lens.mirrored, "the device swaps left and right"},
          }};
}

OptionSection correction_section(DepthCorrection& c) {
  return {"depth_correction",
          "True depth from the device's: (c0 + c1 z + c2 z² + c3 z³) · factor.",
          {
              {"c0_m", &c.c0_m, "", {-1, 1}},
              {"c1", &c.c1, "", {0.5, 2}},
              {"c2_per_m", &c.c2_per_m, "", {-1, 1}},
              {"c3_per_m2", &c.c3_per_m2, "", {-1, 1}},
              {"factor_file", &c.factor_file, "16-bit PNG, 32768 · the factor of each pixel"},
          }};
}

struct Motion {
  double x_m = 0, y_m = 0, z_m = 0, rx_rad = 0, ry_rad = 0, rz_rad = 0;
  [[nodiscard]] bool is_identity() const {
    return x_m == 0 && y_m == 0 && z_m == 0 && rx_rad == 0 && ry_rad == 0 && rz_rad == 0;
  }
};

OptionSection motion_section(Motion& m) {
  constexpr OptionRange kMetres{-2, 2}, kRadians{-3.2, 3.2};
  return {"T_color_depth",
          "Maps points of the depth camera's frame to the colour camera's (x right, y down, z forward).",
          {
              {"x_m", &m.x_m, "translation", kMetres},
              {"y_m", &m.y_m, "translation", kMetres},
              {"z_m", &m.z_m, "translation", kMetres},
              {"rx_rad", &m.rx_rad, "rotation vector: axis times angle", kRadians},
              {"ry_rad", &m.ry_rad, "rotation vector", kRadians},
              {"rz_rad", &m.rz_rad, "rotation vector", kRadians},
          }};
}

void check_lens(const std::string& where, const char* section, const LensCalibration& lens,
                std::vector<std::string>* problems) {
  const PinholeCamera& c = lens.camera;
  const bool any = c.width != 0 || c.height != 0 || c.fx != 0 || c.fy != 0 || c.cx != 0 || c.cy != 0;
  if (any && !c.is_valid())
    problems->push_back(where + section + ": give all of width height fx fy cx cy, or none of them");
}

void check_correction(const std::string& where, const DepthCorrection& correction,
                      std::vector<std::string>* problems) {
  constexpr double kFrom_m = 0.3, kTo_m = 8.0, kStep_m = 0.1;
  for (double z = kFrom_m; z < kTo_m; z += kStep_m) {
    if (correction.polynomial(z) > 0 && correction.polynomial(z + kStep_m) > correction.polynomial(z))
      continue;
    problems->push_back(where +
                        "depth_correction: the corrected depth must be positive and grow with depth, "
                        "from 0.3 to 8 m; check the signs of c0_m c1 c2_per_m c3_per_m2");
    return;
  }
}

}  // namespace

bool read_camera_file(const std::string& path, CameraCalibration* calibration,
                      std::vector<std::string>* problems) {
  const std::size_t before = problems->size();
  CameraCalibration& c = *calibration;
  c.file = path;
  Motion motion;
  OptionTable table = {
      lens_section("depth", "The depth camera.", c.depth), correction_section(c.correction),
      lens_section("color", "The colour camera; without intrinsics: aligned to depth.", c.color),
      motion_section(motion)};
  table.front().options.push_back({"scale", &c.depth_scale, "raw depth units per metre", {0, 1e6}});
  if (!read_toml_file(path, table, problems)) return false;
  const std::string where = path + ": ";
  check_lens(where, "depth", c.depth, problems);
  check_lens(where, "color", c.color, problems);
  check_correction(where, c.correction, problems);
  if (!motion.is_identity() && c.color_is_aligned())
    problems->push_back(where + "T_color_depth needs the colour camera: width height fx fy cx cy in [color]");
  c.T_color_depth = Se3(so3_exp({motion.rx_rad, motion.ry_rad, motion.rz_rad}),
                        Eigen::Vector3d(motion.x_m, motion.y_m, motion.z_m));
  if (!c.correction.factor_file.empty())
    c.correction.factor_file =
        (std::filesystem::path(path).parent_path() / c.correction.factor_file).string();
  return problems->size() == before;
}

}  // namespace loopsift
