// SPDX-License-Identifier: MIT
#include "drivers/synth/synth_source.hpp"

#include <chrono>
#include <cmath>

#include "drivers/synth/synth_sequence.hpp"

namespace loopsift {
namespace {

class SynthSource final : public FrameSource {
 public:
  SynthSource(const SynthSequence& sequence, std::unique_ptr<SequenceRenderer> renderer)
      : renderer_(std::move(renderer)) {
    const SynthSettings& settings = sequence.settings;
    info_.description = "synth " + settings.name + ", " + std::to_string(renderer_->size()) + " frames";
    info_.camera = settings.camera;
    info_.depth_unit_m = settings.noise.depth_unit_m;
    info_.color_width = settings.color ? settings.camera.width : 0;
    info_.color_height = settings.color ? settings.camera.height : 0;
    info_.nominal_rate_hz = settings.rate_hz;
    info_.frame_count = static_cast<std::int64_t>(renderer_->size());
  }

  const SourceInfo& info() const override { return info_; }
  const std::string& message() const override { return message_; }

  ReadStatus read(RawFrame& frame, int /*timeout_ms*/) override {
    if (next_ == renderer_->size()) return ReadStatus::kEnd;
    const int width = info_.camera.width, height = info_.camera.height;
    const bool color = info_.color_width > 0 && !frame.color_buffer.empty();
    frame.depth = {frame.depth_buffer.data(), width, height};
    frame.color = color ? ImageView<Rgb8>(frame.color_buffer.data(), width, height) : ImageView<Rgb8>();
    renderer_->render(next_, &scratch_, frame.depth, frame.color);
    frame.timestamp_ns = std::llround(renderer_->time_s(next_) * 1e9);
    frame.sequence = static_cast<std::int64_t>(next_);
    frame.captured_ns = std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    ++next_;
    return ReadStatus::kFrame;
  }

 private:
  std::unique_ptr<SequenceRenderer> renderer_;
  RenderedFrame scratch_;
  SourceInfo info_;
  std::string message_;
  std::size_t next_ = 0;
};

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_synth(const std::string& scene, const SourceOptions& options) {
  auto sequence = make_synth_sequence(scene, options);
  if (!sequence) return sequence.error();
  auto renderer = SequenceRenderer::create(*sequence);
  if (!renderer) return renderer.error();
  return std::unique_ptr<FrameSource>(std::make_unique<SynthSource>(*sequence, std::move(*renderer)));
}

}  // namespace loopsift
