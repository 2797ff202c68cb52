// SPDX-License-Identifier: MIT
#include "drivers/replay/replay_source.hpp"

#include "drivers/replay/folder_source.hpp"
#include "drivers/replay/klg_source.hpp"

namespace loopsift {
namespace {

Expected<Recording> list_recording(const std::string& format, const std::string& folder,
                                   const ListOptions& options) {
  if (format == "tum") return list_tum(folder, options);
  if (format == "7scenes") return list_7scenes(folder, options);
  if (format == "redwood") return list_redwood(folder, options);
  if (format == "sun3d") return list_sun3d(folder, options);
  return Error{ErrorCode::kUsage, "replay: unknown format '" + format + "'; known are " + kReplayFormats};
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_replay(const std::string& format, const std::string& path,
                                                   const SourceOptions& options) {
  if (path.empty()) return Error{ErrorCode::kUsage, "replay:" + format + ": the path is missing"};
  if (format == "klg") return KlgSource::open(path, options);
  ListOptions list_options;
  list_options.want_color = options.want_color;
  if (options.rate_hz > 0) list_options.rate_hz = options.rate_hz;
  Expected<Recording> recording = list_recording(format, path, list_options);
  if (!recording) return recording.error();
  return FolderSource::open(format, path, std::move(*recording), list_options, options);
}

}  // namespace loopsift
