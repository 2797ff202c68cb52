// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>

#include "core/base/text_file.hpp"
#include "drivers/replay/recording.hpp"

namespace loopsift {
namespace {

// Published calibrations of the benchmark's three cameras, told by the folder's name; else the ROS default
// that the benchmark itself recommends. All 640 × 480, 5000 units per metre.
Calibration tum_calibration(const std::string& folder) {
  const auto named = [&](const char* part) { return folder.find(part) != std::string::npos; };
  Calibration calibration{{640, 480, 525.0F, 525.0F, 319.5F, 239.5F}, 5000};
  if (named("freiburg1")) calibration.camera = {640, 480, 517.3F, 516.5F, 318.6F, 255.3F};
  if (named("freiburg2")) calibration.camera = {640, 480, 520.9F, 521.0F, 325.1F, 249.7F};
  if (named("freiburg3")) calibration.camera = {640, 480, 535.4F, 539.2F, 320.1F, 247.6F};
  return calibration;
}

struct TimedFiles {
  std::vector<std::int64_t> times;
  std::vector<std::string> paths;
};

bool names_depth(std::string_view path) { return path.find("depth") != std::string_view::npos; }

Status parse_time(const TextFile& file, std::size_t column, std::int64_t* time) {
  if (parse_seconds(file.words()[column], time)) return {};
  return file.error("'" + std::string(file.words()[column]) + "' is not a time in seconds");
}

Status append(const TextFile& file, const std::string& folder, std::size_t column, TimedFiles* list) {
  std::int64_t time = 0;
  const Status status = parse_time(file, column, &time);
  if (!status) return status;
  if (!list->times.empty() && time <= list->times.back()) {
    return file.error("time does not go forward here; sort the lines by time and remove doubles");
  }
  list->times.push_back(time);
  list->paths.push_back(folder + "/" + std::string(file.words()[column + 1]));
  return {};
}

// depth.txt or rgb.txt: `time path` per line.
Expected<TimedFiles> read_list(const std::string& folder, const std::string& name) {
  Expected<TextFile> file = TextFile::open(folder + "/" + name);
  if (!file) return file.error();
  TimedFiles list;
  while (file->next()) {
    if (file->words().size() != 2) return file->error("expected `time path`");
    const Status status = append(*file, folder, 0, &list);
    if (!status) return status.error();
  }
  return list;
}

// associations.txt: the column whose path speaks of depth is the depth.
Expected<Recording> read_associations(TextFile& file, const std::string& folder, bool want_color) {
  Recording recording;
  TimedFiles depth;
  while (file.next()) {
    const auto& words = file.words();
    if (words.size() != 2 && words.size() != 4)
      return file.error("expected `time depth` or `time depth time color`");
    const bool with_color = words.size() == 4;
    if (with_color && names_depth(words[1]) == names_depth(words[3])) {
      return file.error("cannot tell depth from colour: exactly one of the two paths must contain 'depth'");
    }
    const std::size_t depth_column = with_color && names_depth(words[3]) ? 2 : 0;
    const Status status = append(file, folder, depth_column, &depth);
    if (!status) return status.error();
    std::int64_t color_time = 0;
    const Status color_status = with_color ? parse_time(file, 2 - depth_column, &color_time) : Status();
    if (!color_status) return color_status.error();
    RecordedFrame frame{depth.times.back(), static_cast<std::int64_t>(recording.frames.size()),
                        depth.paths.back(), ""};
    if (with_color && want_color) frame.color_path = folder + "/" + std::string(words[3 - depth_column]);
    recording.frames.push_back(std::move(frame));
  }
  return recording;
}

Expected<Recording> pair_lists(const std::string& folder, const ListOptions& options) {
  const Expected<TimedFiles> depth = read_list(folder, "depth.txt");
  if (!depth) {
    if (depth.error().code != ErrorCode::kNotFound) return depth.error();
    return Error{ErrorCode::kNotFound,
                 folder + ": holds neither associations.txt nor depth.txt; is it a TUM sequence?"};
  }
  Expected<TimedFiles> color = TimedFiles();
  if (options.want_color) color = read_list(folder, "rgb.txt");
  if (!color && color.error().code != ErrorCode::kNotFound) return color.error();
  const TimedFiles none;
  const TimedFiles& colors = color.ok() ? *color : none;
  const auto limit = static_cast<std::int64_t>(0.5e9 / options.rate_hz);
  const std::vector<int> pairs = pair_nearest(depth->times, colors.times, limit);
  if (!colors.times.empty() && std::all_of(pairs.begin(), pairs.end(), [](int c) { return c < 0; })) {
    return Error{ErrorCode::kFormat, folder + ": no time in rgb.txt lies within half a frame (" +
                                         std::to_string(limit / 1000000) +
                                         " ms) of one in depth.txt; are the two from the same recording?"};
  }
  Recording recording;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    recording.frames.push_back({depth->times[k], static_cast<std::int64_t>(k), depth->paths[k],
                                pairs[k] < 0 ? "" : colors.paths[static_cast<std::size_t>(pairs[k])]});
  }
  return recording;
}

}  // namespace

Expected<Recording> list_tum(const std::string& folder, const ListOptions& options) {
  const Expected<std::vector<std::string>> names = list_folder(folder);
  if (!names) return names.error();
  Expected<TextFile> associations = TextFile::open(folder + "/associations.txt");
  if (!associations && associations.error().code != ErrorCode::kNotFound) return associations.error();
  Expected<Recording> recording = associations.ok()
                                      ? read_associations(*associations, folder, options.want_color)
                                      : pair_lists(folder, options);
  if (!recording) return recording;
  if (recording->frames.empty())
    return Error{ErrorCode::kFormat, folder + ": the list of depth images is empty"};
  recording->defaults = tum_calibration(std::filesystem::absolute(folder).string());
  return recording;
}

}  // namespace loopsift
