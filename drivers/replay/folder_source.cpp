// SPDX-License-Identifier: MIT
#include "drivers/replay/folder_source.hpp"

#include <cassert>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

struct Probe {
  std::string path;  // empty: no readable image
  ImageSize size;
  std::string problem;  // of the first image that could not be read
};

// The first image that can be read, by way of either path of the frames.
Probe probe_images(const Recording& recording, std::string RecordedFrame::*path) {
  Probe probe;
  for (const RecordedFrame& frame : recording.frames) {
    if ((frame.*path).empty()) continue;
    const Expected<ImageSize> size = read_image_size(frame.*path);
    if (size.ok()) {
      probe.path = frame.*path;
      probe.size = *size;
      break;
    }
    if (probe.problem.empty()) probe.problem = size.error().message;
  }
  return probe;
}

// sun3d's rotation undone.
void rotate_bits(const ImageView<std::uint16_t>& image) {
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.data[i] = static_cast<std::uint16_t>(image.data[i] >> 3 | image.data[i] << 13);
  }
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> FolderSource::open(const std::string& format,
                                                          const std::string& folder, Recording recording,
                                                          const ListOptions& list_options,
                                                          const SourceOptions& options) {
  Expected<Calibration> calibration = resolve_calibration(recording.defaults, folder, options);
  if (!calibration) return calibration.error();
  const Probe depth = probe_images(recording, &RecordedFrame::depth_path);
  if (depth.path.empty()) {
    return Error{ErrorCode::kFormat, folder + ": none of its " + std::to_string(recording.frames.size()) +
                                         " depth images can be read; the first: " + depth.problem};
  }
  const Status fits =
      fit_to_image(folder, depth.path, depth.size.width, depth.size.height, &calibration->camera);
  if (!fits) return fits.error();
  SourceInfo info;
  info.description = format + " " + folder + ", " + std::to_string(recording.frames.size()) + " frames";
  info.camera = calibration->camera;
  info.depth_unit_m = 1.0 / calibration->depth_scale;
  if (options.want_color) {
    const ImageSize color = probe_images(recording, &RecordedFrame::color_path).size;
    info.color_width = color.width;
    info.color_height = color.height;
  }
  info.nominal_rate_hz = list_options.rate_hz;
  info.frame_count = static_cast<std::int64_t>(recording.frames.size());
  return std::unique_ptr<FrameSource>(std::make_unique<FolderSource>(std::move(info), std::move(recording)));
}

FolderSource::FolderSource(SourceInfo info, Recording recording)
    : info_(std::move(info)),
      recording_(std::move(recording)),
      reader_({info_.camera.width, info_.camera.height}, {info_.color_width, info_.color_height}) {
  message_.reserve(1024);
}

void FolderSource::explain(const std::string& path, const char* problem) {
  message_.append(path).append(": ").append(problem);
}

ReadStatus FolderSource::read(RawFrame& frame, int /*timeout_ms*/) {
  message_.clear();
  if (next_ == recording_.frames.size()) return ReadStatus::kEnd;
  const RecordedFrame& recorded = recording_.frames[next_++];
  frame.timestamp_ns = recorded.timestamp_ns;
  frame.sequence = recorded.sequence;
  frame.captured_ns = steady_now_ns();
  frame.depth = ImageView(frame.depth_buffer.data(), info_.camera.width, info_.camera.height);
  frame.color = {};
  assert(frame.depth_buffer.size() >= frame.depth.size());
  if (const char* problem = reader_.read_depth(recorded.depth_path, frame.depth)) {
    explain(recorded.depth_path, problem);
    return ReadStatus::kBad;
  }
  if (recording_.rotated_bits) rotate_bits(frame.depth);
  if (info_.color_width == 0 || recorded.color_path.empty()) return ReadStatus::kFrame;
  const ImageView<Rgb8> color(frame.color_buffer.data(), info_.color_width, info_.color_height);
  assert(frame.color_buffer.size() >= color.size());
  if (const char* problem = reader_.read_color(recorded.color_path, color)) {
    explain(recorded.color_path, problem);
  } else {
    frame.color = color;
  }
  return ReadStatus::kFrame;
}

}  // namespace loopsift
