// SPDX-License-Identifier: MIT
// The driver of `synth:SCENE`: frames rendered as they are read.
// In: a scene string (synth_sequence.hpp has its syntax, builtin_scenes.hpp the names). Out: RawFrames, as
// fast as they are asked for. Thread: the reader's; read() does not allocate after its first frame. Every run
// of a scene with the same keys gives the same bytes on the same machine.
#pragma once
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift {

/// `scene` without "synth:". Options apply where the scene's own keys say nothing; depth_scale sets the raw
/// unit. Errors name the scene or key and list the valid ones.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_synth(const std::string& scene,
                                                                const SourceOptions& options);

}  // namespace loopsift
