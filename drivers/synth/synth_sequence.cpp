// SPDX-License-Identifier: MIT
#include "drivers/synth/synth_sequence.hpp"

#include <algorithm>

#include "drivers/synth/builtin_scenes.hpp"
#include "drivers/synth/mesh_io.hpp"

namespace loopsift {
namespace {

void keep_first(int frames, Trajectory* trajectory) {
  const auto wanted = static_cast<std::size_t>(frames);
  if (frames > 0 && wanted < trajectory->poses.size()) trajectory->poses.resize(wanted);
}

// Every second lap leads back, so that the camera never jumps; a turning point is one frame.
void repeat(int laps, double rate_hz, Trajectory* trajectory) {
  const std::vector<StampedPose> way = trajectory->poses;
  for (int lap = 1; lap < laps; ++lap) {
    for (std::size_t k = 1; k < way.size(); ++k) {
      StampedPose pose = lap % 2 == 1 ? way[way.size() - 1 - k] : way[k];
      pose.time_s = static_cast<double>(trajectory->poses.size()) / rate_hz;
      trajectory->poses.push_back(pose);
    }
  }
}

}  // namespace

Expected<SynthSequence> make_synth_sequence(const std::string& scene, const SourceOptions& options) {
  auto settings = parse_synth_settings(scene, options);
  if (!settings) return settings.error();
  auto builtin = make_builtin_scene(settings->name);
  if (!builtin) return builtin.error();
  builtin->pace.rate_hz = settings->rate_hz;
  SynthSequence sequence{*settings, std::move(builtin->scene), walk(builtin->waypoints, builtin->pace)};
  repeat(settings->laps, settings->rate_hz, &sequence.trajectory);
  keep_first(settings->frames, &sequence.trajectory);
  return sequence;
}

Expected<SynthSequence> make_mesh_sequence(const std::string& mesh_path, const std::string& trajectory_path,
                                           const Eigen::Vector3d& offset_m, const SynthSettings& settings) {
  auto mesh = read_mesh(mesh_path);
  if (!mesh) return mesh.error();
  auto trajectory = read_trajectory(trajectory_path);
  if (!trajectory) return trajectory.error();
  if (trajectory->poses.empty()) return Error{ErrorCode::kFormat, trajectory_path + ": holds no poses"};
  const double start = trajectory->poses.front().time_s;
  for (std::size_t k = 0; k < trajectory->poses.size(); ++k) {
    StampedPose& pose = trajectory->poses[k];
    pose.time_s = trajectory->indexed ? static_cast<double>(k) / settings.rate_hz : pose.time_s - start;
    pose.T_world_camera = Se3(pose.T_world_camera.rotation(), pose.T_world_camera.translation() + offset_m);
  }
  trajectory->indexed = false;
  keep_first(settings.frames, &*trajectory);
  return SynthSequence{settings, make_scene(std::move(*mesh)), std::move(*trajectory)};
}

SequenceRenderer::SequenceRenderer(const SynthSequence& sequence, std::unique_ptr<Renderer> renderer)
    : settings_(sequence.settings),
      poses_(sequence.trajectory),
      renderer_(std::move(renderer)),
      noise_(settings_.camera, settings_.noise) {}

Expected<std::unique_ptr<SequenceRenderer>> SequenceRenderer::create(const SynthSequence& sequence) {
  auto renderer = Renderer::create(sequence.scene);
  if (!renderer) return renderer.error();
  return std::unique_ptr<SequenceRenderer>(new SequenceRenderer(sequence, std::move(*renderer)));
}

void SequenceRenderer::render(std::size_t index, RenderedFrame* scratch, ImageView<std::uint16_t> depth,
                              ImageView<Rgb8> color) const {
  renderer_->render(settings_.camera, poses_.poses[index].T_world_camera, !color.empty(), scratch);
  noise_.apply_depth(*scratch, index, depth);
  if (!color.empty()) noise_.apply_color(*scratch, index, color);
}

}  // namespace loopsift
