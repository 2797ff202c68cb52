// SPDX-License-Identifier: MIT
// Recordings in the formats that the replay driver reads, frame by frame. In: raw frames in order of time.
// Out: files whose depth is in the format's own unit (TUM 1/5000 m, the others millimetres), with a
// camera.txt that says so. Depth that does not fit 16 bits becomes invalid. Colour is stored as JPEG (quality
// 95), which loses a little each time. Desk code: allocates; one thread.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/image.hpp"
#include "core/geometry/raw_frame.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift::tool {

class RecordingWriter {
 public:
  virtual ~RecordingWriter() = default;
  /// The next frame: depth already in the format's unit, colour empty where there is none.
  [[nodiscard]] virtual Status write(std::int64_t timestamp_ns, const ImageView<const std::uint16_t>& depth,
                                     const ImageView<const Rgb8>& color) = 0;
  /// Lists, counts: call once after the last frame.
  [[nodiscard]] virtual Status finish() = 0;
  /// Raw units per metre of what write() takes.
  [[nodiscard]] virtual double depth_scale() const { return 1000; }
};

/// "klg" (`path` is a file), "tum", "7scenes", "redwood", "sun3d" (`path` is a folder). What is missing of
/// the path is made. Errors: an unknown format, a path that cannot be made or written to. ".oni" is refused
/// with a word: writing it takes OpenNI2's own recorder.
[[nodiscard]] Expected<std::unique_ptr<RecordingWriter>> open_recording_writer(const std::string& format,
                                                                               const std::string& path,
                                                                               const SourceInfo& info);

struct CopiedFrames {
  std::int64_t frames = 0;
  std::int64_t unusable = 0;  ///< could not be read; each was told on stderr
};

/// All frames of a source into a writer; finishes it. Error: the source was lost, a file could not be
/// written, no frame at all.
[[nodiscard]] Expected<CopiedFrames> copy_recording(FrameSource& source, RecordingWriter& writer);

}  // namespace loopsift::tool
