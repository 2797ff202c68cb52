// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/sequence_writer.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "drivers/replay/image_file.hpp"
#include "drivers/replay/png16.hpp"
#include "drivers/synth/mesh_io.hpp"
#include "drivers/synth/odometry_drift.hpp"

namespace loopsift::tool {
namespace {

constexpr int kJpegQuality = 92;

std::string file_name(const char* format, std::size_t index) {
  char name[64];
  std::snprintf(name, sizeof name, format, index);
  return name;
}
std::string depth_name(std::size_t index) { return file_name("depth/%06zu.png", index); }
std::string color_name(std::size_t index) { return file_name("rgb/%06zu.jpg", index); }

std::string seconds(double time_s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9f", time_s);
  return text;
}

Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) return Error{ErrorCode::kIo, path + ": cannot be made: " + error.message()};
  return {};
}

Status write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file)
    return Error{ErrorCode::kIo, path + ": cannot be written; check the folder's rights and free space"};
  return {};
}

Status make_folders(const SynthSequence& sequence, const SequenceWriterOptions& options) {
  if (!options.images) return make_folder(options.folder);
  if (Status s = make_folder(options.folder + "/depth"); !s) return s;
  return sequence.settings.color ? make_folder(options.folder + "/rgb") : Status();
}

/// Renders and writes every frame; `valid_pixels` counts those with depth.
Status write_images(const SynthSequence& sequence, const std::string& folder, std::int64_t* valid_pixels) {
  auto renderer = SequenceRenderer::create(sequence);
  if (!renderer) return renderer.error();
  const int width = sequence.settings.camera.width, height = sequence.settings.camera.height;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const auto count = static_cast<std::int64_t>((*renderer)->size());
  std::int64_t valid = 0;
  Status failure;
#pragma omp parallel reduction(+ : valid)
  {
    RenderedFrame scratch;
    std::vector<std::uint16_t> depth(pixels);
    std::vector<Rgb8> color(sequence.settings.color ? pixels : 0);
    const ImageView<std::uint16_t> depth_view(depth.data(), width, height);
    const ImageView<Rgb8> color_view =
        color.empty() ? ImageView<Rgb8>() : ImageView<Rgb8>(color.data(), width, height);
#pragma omp for schedule(dynamic, 4)
    for (std::int64_t k = 0; k < count; ++k) {
      const auto index = static_cast<std::size_t>(k);
      (*renderer)->render(index, &scratch, depth_view, color_view);
      valid += static_cast<std::int64_t>(pixels) - std::count(depth.begin(), depth.end(), 0);
      Status status = write_png16(folder + "/" + depth_name(index), depth_view);
      if (status && !color.empty())
        status = write_jpeg(folder + "/" + color_name(index), color_view, kJpegQuality);
      if (!status) {
#pragma omp critical
        failure = status;
      }
    }
  }
  *valid_pixels = valid;
  return failure;
}

Status write_lists(const SynthSequence& sequence, const std::string& folder) {
  std::string depth = "# timestamp filename\n", color = depth, both;
  for (std::size_t k = 0; k < sequence.trajectory.poses.size(); ++k) {
    const std::string time = seconds(sequence.trajectory.poses[k].time_s);
    depth += time + " " + depth_name(k) + "\n";
    color += time + " " + color_name(k) + "\n";
    both += time + " " + depth_name(k);
    both += sequence.settings.color ? " " + time + " " + color_name(k) + "\n" : "\n";
  }
  if (Status s = write_text(folder + "/depth.txt", depth); !s) return s;
  if (sequence.settings.color)
    if (Status s = write_text(folder + "/rgb.txt", color); !s) return s;
  return write_text(folder + "/associations.txt", both);
}

Status write_camera(const SynthSettings& settings, const std::string& folder) {
  const PinholeCamera& c = settings.camera;
  std::ostringstream text;
  text.precision(9);
  text << "fx " << c.fx << "\nfy " << c.fy << "\ncx " << c.cx << "\ncy " << c.cy << "\nwidth " << c.width
       << "\nheight " << c.height << "\ndepth_scale " << 1.0 / settings.noise.depth_unit_m << "\n";
  return write_text(folder + "/camera.txt", text.str());
}

/// Everything but the images.
Status write_tables(const SynthSequence& sequence, const SequenceWriterOptions& options) {
  const std::string& folder = options.folder;
  if (options.images)
    if (Status s = write_lists(sequence, folder); !s) return s;
  if (Status s = write_camera(sequence.settings, folder); !s) return s;
  if (Status s = write_trajectory_tum(folder + "/groundtruth.txt", sequence.trajectory); !s) return s;
  if (options.drift_m > 0) {
    const Trajectory odometry = drifting_odometry(sequence.trajectory, options.drift_m, options.seed);
    if (Status s = write_trajectory_tum(folder + "/odometry.txt", odometry); !s) return s;
  }
  return write_ply(folder + "/mesh.ply", sequence.scene.mesh);
}

}  // namespace

Expected<WrittenSequence> write_sequence(const SynthSequence& sequence,
                                         const SequenceWriterOptions& options) {
  if (Status s = make_folders(sequence, options); !s) return s.error();
  if (Status s = write_tables(sequence, options); !s) return s.error();
  std::int64_t valid_pixels = 0;
  if (options.images)
    if (Status s = write_images(sequence, options.folder, &valid_pixels); !s) return s.error();

  const std::vector<StampedPose>& poses = sequence.trajectory.poses;
  const PinholeCamera& camera = sequence.settings.camera;
  WrittenSequence written;
  written.frames = poses.size();
  written.duration_s = poses.back().time_s - poses.front().time_s;
  for (std::size_t k = 1; k < poses.size(); ++k)
    written.length_m +=
        (poses[k].T_world_camera.translation() - poses[k - 1].T_world_camera.translation()).norm();
  written.valid_fraction = static_cast<double>(valid_pixels) / static_cast<double>(poses.size()) /
                           static_cast<double>(camera.width) / static_cast<double>(camera.height);
  return written;
}

}  // namespace loopsift::tool
