// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "drivers/synth/synth_sequence.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/sequence_writer.hpp"

namespace loopsift::tool {
namespace {

struct SynthOptions {
  std::string scene, mesh, trajectory, out, json;
  std::vector<double> offset = {0, 0, 0};
  std::vector<double> camera;  // fx fy cx cy width height, or empty
  int frames = 0;
  bool no_noise = false, no_distortion = false, no_images = false, color = true;
  double depth_scale = 5000;
  std::uint64_t seed = 1;
  double drift_m = 0;
};

/// The options in the syntax of scene strings, behind the keys that the scene brings itself.
std::string scene_string(const SynthOptions& options) {
  std::string text = options.mesh.empty() ? options.scene : "mesh";
  const auto add = [&](const std::string& item) {
    text += (text.find('?') == std::string::npos ? "?" : "&") + item;
  };
  if (options.frames > 0) add("frames=" + std::to_string(options.frames));
  if (options.no_noise) add("noise=0");
  if (options.no_distortion) add("distortion=0");
  return text;
}

Status check_camera(const std::vector<double>& c) {
  if (c.empty() || (c[0] > 0 && c[1] > 0 && c[4] >= 16 && c[5] >= 16)) return {};
  return Error{ErrorCode::kUsage, "--camera: fx and fy must be positive, width and height at least 16"};
}

SourceOptions source_options(const SynthOptions& options) {
  SourceOptions source;
  source.seed = options.seed;
  source.want_color = options.color;
  source.depth_scale = options.depth_scale;
  if (options.camera.size() == 6) {
    const std::vector<double>& c = options.camera;
    source.camera = {static_cast<int>(c[4]),   static_cast<int>(c[5]),   static_cast<float>(c[0]),
                     static_cast<float>(c[1]), static_cast<float>(c[2]), static_cast<float>(c[3])};
  }
  return source;
}

Expected<SynthSequence> make_sequence(const SynthOptions& options) {
  if (options.mesh.empty() && options.scene.empty())
    return Error{ErrorCode::kUsage, "synth needs a SCENE, or --mesh and --trajectory"};
  if (Status s = check_camera(options.camera); !s) return s.error();
  if (options.mesh.empty()) return make_synth_sequence(scene_string(options), source_options(options));
  auto settings = parse_synth_settings(scene_string(options), source_options(options));
  if (!settings) return settings.error();
  return make_mesh_sequence(options.mesh, options.trajectory,
                            {options.offset[0], options.offset[1], options.offset[2]}, *settings);
}

int synth(const SynthOptions& options) {
  const auto sequence = make_sequence(options);
  if (!sequence) return fail(sequence.error());
  const auto written =
      write_sequence(*sequence, {options.out, options.drift_m, options.seed, !options.no_images});
  if (!written) return fail(written.error());
  const nlohmann::json valid = options.no_images ? nlohmann::json() : nlohmann::json(written->valid_fraction);
  return show_figures({{"frames", "frames", written->frames, ""},
                       {"duration", "duration_s", written->duration_s, "s"},
                       {"length of the way", "length_m", written->length_m, "m"},
                       {"pixels with depth", "valid_fraction", valid, ""},
                       {"triangles", "triangles", sequence->scene.mesh.triangles.size(), ""},
                       {"drift at the end", "drift_m", options.drift_m, "m"}},
                      options.json);
}

void add_scene_options(CLI::App* command, SynthOptions* options) {
  auto* scene = command->add_option("scene", options->scene,
                                    "built-in scene: room, rooms, lookalike, corridor, notexture, rotation; "
                                    "keys may follow: room?rate=15&width=320&height=240");
  auto* mesh = command->add_option("--mesh", options->mesh, "render this OBJ or PLY instead");
  auto* trajectory = command->add_option("--trajectory", options->trajectory,
                                         "camera-to-world poses for --mesh: TUM text or redwood .log");
  mesh->needs(trajectory)->excludes(scene);
  trajectory->needs(mesh);
  command->add_option("--offset", options->offset, "x y z in metres, added to the positions of --trajectory")
      ->expected(3)
      ->needs(trajectory);
}

}  // namespace

void add_synth_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<SynthOptions>();
  CLI::App* command = app.add_subcommand("synth", "Renders an RGB-D sequence with its ground truth");
  add_scene_options(command, options.get());
  command->add_option("--out", options->out, "folder to write to; made when missing")->required();
  command->add_option("--frames", options->frames, "only the first N frames")->check(CLI::PositiveNumber);
  command->add_flag("--no-noise", options->no_noise, "exact depth: no noise, no holes, no range limits");
  command->add_flag("--no-distortion", options->no_distortion, "without the camera's smooth depth error");
  command->add_option("--seed", options->seed, "of noise, distortion and drift")->capture_default_str();
  command->add_flag("--color,!--no-color", options->color, "with colour images (default) or without");
  command->add_flag(
      "--no-images", options->no_images,
      "only groundtruth.txt, mesh.ply, camera.txt and odometry.txt: what synth:SCENE is measured by");
  command->add_option("--camera", options->camera, "fx fy cx cy width height, pixels")->expected(6);
  command->add_option("--depth-scale", options->depth_scale, "raw units per metre")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--drift", options->drift_m,
                   "also write odometry.txt: the truth with tracking errors that end this many metres off")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--json", options->json, "write the figures to this file");
  command->callback([options, exit_code] { *exit_code = synth(*options); });
}

}  // namespace loopsift::tool
