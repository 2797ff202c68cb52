// SPDX-License-Identifier: MIT
// Rendered sequences with everything that is known about them: scene, true trajectory, camera. Set-up code:
// allocates.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/raw_frame.hpp"
#include "core/geometry/trajectory.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/synth/noise.hpp"
#include "drivers/synth/renderer.hpp"
#include "drivers/synth/scene.hpp"

namespace loopsift {

/// A scene string, taken apart: NAME[?KEY=VALUE[&KEY=VALUE]…].
///
///   frames=N        the first N frames (same speed); all of them when left out
///   laps=N          the way N times, there and back in turn (default 1)
///   noise=0|1       sensor noise and holes (default 1)
///   distortion=0|1  the camera's smooth depth distortion (default 1)
///   seed=N          of noise and distortion
///   width=N         pixels; intrinsics scale along (default 640)
///   height=N        pixels (default 480)
///   rate=F          frames per second (default 30)
///   color=0|1       whether there is colour (default 1)
///
/// e.g. `room?frames=300&noise=0&distortion=0`.
struct SynthSettings {
  std::string name;  ///< of a built-in scene
  PinholeCamera camera{640, 480, 525.0F, 525.0F, 319.5F, 239.5F};
  NoiseSettings noise;
  int frames = 0;  ///< 0: all
  int laps = 1;
  double rate_hz = 30;
  bool color = true;
};

/// Options first, then the keys of the string, which win. Errors name the key, its value and the valid keys.
[[nodiscard]] Expected<SynthSettings> parse_synth_settings(const std::string& scene,
                                                           const SourceOptions& options);

/// Pose k belongs to frame k; times in seconds from 0 at the settings' rate.
struct SynthSequence {
  SynthSettings settings;
  Scene scene;
  Trajectory trajectory;
};

/// A built-in scene by its string.
[[nodiscard]] Expected<SynthSequence> make_synth_sequence(const std::string& scene,
                                                          const SourceOptions& options);

/// Somebody else's mesh seen along somebody else's camera-to-world trajectory, to whose positions `offset_m`
/// is added. Poses of a trajectory without time stamps follow at the settings' rate; others keep their times,
/// counted from the first.
[[nodiscard]] Expected<SynthSequence> make_mesh_sequence(const std::string& mesh_path,
                                                         const std::string& trajectory_path,
                                                         const Eigen::Vector3d& offset_m,
                                                         const SynthSettings& settings);

/// Renders frames of a sequence in any order. render() may run in several threads, each with its own scratch.
class SequenceRenderer {
 public:
  [[nodiscard]] static Expected<std::unique_ptr<SequenceRenderer>> create(const SynthSequence& sequence);
  [[nodiscard]] std::size_t size() const { return poses_.poses.size(); }
  [[nodiscard]] double time_s(std::size_t index) const { return poses_.poses[index].time_s; }
  /// Views of the camera's size; `color` may be empty. Allocates only when `scratch` grows.
  void render(std::size_t index, RenderedFrame* scratch, ImageView<std::uint16_t> depth,
              ImageView<Rgb8> color) const;

 private:
  SequenceRenderer(const SynthSequence& sequence, std::unique_ptr<Renderer> renderer);
  SynthSettings settings_;
  Trajectory poses_;
  std::unique_ptr<Renderer> renderer_;
  NoiseModel noise_;
};

}  // namespace loopsift
