// SPDX-License-Identifier: MIT
// --record: what keeping frames costs the capture thread, and the process, beside the camera itself.
#include <zlib.h>

#include <cstdio>

#include "core/base/steady_time.hpp"
#include "drivers/replay/image_file.hpp"
#include "firmware_app/recorder.hpp"
#include "tests/bench/camera_load.hpp"
#include "tests/support/in_arena.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift::bench {
namespace {

// A camera that takes no time, and whose frames are kept.
class KeptCamera final : public FrameSource {
 public:
  KeptCamera(const SourceInfo& info, FrameRecorder& recorder) : info_(info), recorder_(recorder) {}
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] const std::string& message() const override { return nothing_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int /*timeout_ms*/) override {
    pace_.wait();
    frame.timestamp_ns = steady_now_ns();
    frame.depth = room_.depth.view();
    frame.color = room_.color.view();
    recorder_.offer(frame);
    return ReadStatus::kFrame;
  }

 private:
  SourceInfo info_;
  FrameRecorder& recorder_;
  Picture room_ = picture();
  Pace pace_;
  std::string nothing_;
};

// As the recorder codes.
double coding_s(const RecordOptions& options) {
  const std::vector<std::uint8_t> depth = test::raw_bytes(picture().depth);
  std::vector<std::uint8_t> packed(compressBound(depth.size()));
  return cost_s([&] {
    uLongf size = packed.size();
    (void)compress2(packed.data(), &size, depth.data(), depth.size(), Z_BEST_SPEED);
    (void)encode_jpeg(picture().color.view(), options.jpeg_quality);
  });
}

}  // namespace

void load_recorder() {
  const test::TemporaryFolder folder;
  SourceInfo info;
  info.camera = usual_options().camera;
  info.color_width = kWidth;
  info.color_height = kHeight;
  RecordOptions options;
  options.folder = folder / "kept";
  const test::InArena<FrameRecorder> recorder(options, info);
  if (!recorder->start().ok()) return print_skipped("record", options.folder);
  KeptCamera camera(info, *recorder);
  measure("--record", camera, coding_s(options), [] {});
  std::printf("  %s\n", recorder->finish().c_str());
}

}  // namespace loopsift::bench
