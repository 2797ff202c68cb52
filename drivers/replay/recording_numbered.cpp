// SPDX-License-Identifier: MIT
// Formats whose files carry their number, and perhaps their time, in their names.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/text_file.hpp"
#include "drivers/replay/recording.hpp"

namespace loopsift {
namespace {

struct NumberedFile {
  std::int64_t number = 0;
  std::int64_t time_us = -1;  // −1: the name carries none
  std::string path;
};

std::int64_t frame_time(std::int64_t number, double rate_hz) {
  return std::llround(static_cast<double>(number) * 1e9 / rate_hz);
}

bool parse_digits(std::string_view text, std::int64_t* value) {
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return problem == std::errc() && end == text.data() + text.size() && *value >= 0 &&
         *value < 1'000'000'000'000'000;
}

bool ends_with(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && name.substr(name.size() - ending.size()) == ending;
}

// NUMBER.ext or NUMBER-MICROSECONDS.ext; other files are not looked at.
bool parse_name(std::string_view name, NumberedFile* file) {
  const std::string_view stem = name.substr(0, name.rfind('.'));
  const std::size_t dash = stem.find('-');
  if (dash != std::string_view::npos && !parse_digits(stem.substr(dash + 1), &file->time_us)) return false;
  return parse_digits(stem.substr(0, dash), &file->number);
}

Expected<std::vector<NumberedFile>> list_images(const std::string& folder) {
  const Expected<std::vector<std::string>> names = list_folder(folder);
  if (!names) return names.error();
  std::vector<NumberedFile> files;
  for (const std::string& name : *names) {
    NumberedFile file;
    if (!ends_with(name, ".png") && !ends_with(name, ".jpg")) continue;
    if (!parse_name(name, &file)) continue;
    file.path = folder + "/" + name;
    files.push_back(std::move(file));
  }
  const auto by_number = [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; };
  std::sort(files.begin(), files.end(), by_number);
  const auto twice =
      std::adjacent_find(files.begin(), files.end(),
                         [](const NumberedFile& a, const NumberedFile& b) { return a.number == b.number; });
  if (twice != files.end()) {
    return Error{ErrorCode::kFormat,
                 twice->path + " and " + (twice + 1)->path + " have the same frame number; remove one"};
  }
  return files;
}

bool has_times(const std::vector<NumberedFile>& files) {
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (files[k].time_us < 0 || (k > 0 && files[k].time_us <= files[k - 1].time_us)) return false;
  }
  return true;
}

// What pairing goes by: times where the names carry them, else frame numbers.
std::vector<std::int64_t> keys(const std::vector<NumberedFile>& files, bool times) {
  std::vector<std::int64_t> all;
  all.reserve(files.size());
  for (const NumberedFile& file : files) all.push_back(times ? file.time_us : file.number);
  return all;
}

Expected<std::vector<NumberedFile>> list_colors(const std::string& folder) {
  for (const char* name : {"image", "color", "rgb"}) {
    Expected<std::vector<NumberedFile>> files = list_images(folder + "/" + name);
    if (files.ok() || files.error().code != ErrorCode::kNotFound) return files;
  }
  return std::vector<NumberedFile>();
}

Expected<Recording> list_numbered(const std::string& folder, const ListOptions& options) {
  const Expected<std::vector<NumberedFile>> depth = list_images(folder + "/depth");
  if (!depth) return depth.error();
  if (depth->empty())
    return Error{ErrorCode::kFormat, folder + "/depth: holds no numbered image (NUMBER.png)"};
  Expected<std::vector<NumberedFile>> color = std::vector<NumberedFile>();
  if (options.want_color) color = list_colors(folder);
  if (!color) return color.error();
  const bool timed = has_times(*depth), pair_by_time = timed && has_times(*color);
  const std::int64_t limit = pair_by_time ? static_cast<std::int64_t>(0.5e6 / options.rate_hz) : 0;
  const std::vector<int> pairs = pair_nearest(keys(*depth, pair_by_time), keys(*color, pair_by_time), limit);
  if (!color->empty() && std::all_of(pairs.begin(), pairs.end(), [](int c) { return c < 0; })) {
    return Error{ErrorCode::kFormat, folder + ": no colour image belongs to any depth image by " +
                                         (pair_by_time ? "time stamp" : "number") +
                                         "; are the two from the same recording?"};
  }
  Recording recording;
  for (std::size_t k = 0; k < depth->size(); ++k) {
    const NumberedFile& file = (*depth)[k];
    const std::int64_t number = file.number - depth->front().number;
    recording.frames.push_back({timed ? file.time_us * 1000 : frame_time(number, options.rate_hz), number,
                                file.path,
                                pairs[k] < 0 ? "" : (*color)[static_cast<std::size_t>(pairs[k])].path});
  }
  return recording;
}

// sun3d: a 3×3 matrix by rows.
Status read_intrinsics(const std::string& path, PinholeCamera* camera) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error().code == ErrorCode::kNotFound ? Status() : Status(file.error());
  double K[9];
  std::size_t count = 0;
  while (file->next()) {
    for (const std::string_view word : file->words()) {
      if (count == 9 || !parse_number(word, &K[count]))
        return file->error("expected a 3x3 matrix of numbers");
      ++count;
    }
  }
  if (count != 9) return file->error("expected a 3x3 matrix of numbers; the file ends early");
  *camera = {0,
             0,
             static_cast<float>(K[0]),
             static_cast<float>(K[4]),
             static_cast<float>(K[2]),
             static_cast<float>(K[5])};
  return {};
}

}  // namespace

Expected<Recording> list_7scenes(const std::string& folder, const ListOptions& options) {
  constexpr std::string_view kHead = "frame-", kTail = ".depth.png";
  const Expected<std::vector<std::string>> names = list_folder(folder);
  if (!names) return names.error();
  Recording recording;
  recording.defaults = {{640, 480, 585.0F, 585.0F, 320.0F, 240.0F}, 1000};
  for (const std::string& name : *names) {
    std::int64_t number = 0;
    if (name.size() <= kHead.size() + kTail.size() || name.compare(0, kHead.size(), kHead) != 0 ||
        !ends_with(name, kTail))
      continue;
    const std::string stem = name.substr(0, name.size() - kTail.size());
    if (!parse_digits(std::string_view(stem).substr(kHead.size()), &number)) continue;
    RecordedFrame frame{frame_time(number, options.rate_hz), number, folder + "/" + name, ""};
    for (const char* ending : {".color.jpg", ".color.png"}) {
      const bool there = std::binary_search(names->begin(), names->end(), stem + ending);
      if (options.want_color && frame.color_path.empty() && there)
        frame.color_path = folder + "/" + stem + ending;
    }
    recording.frames.push_back(std::move(frame));
  }
  std::sort(recording.frames.begin(), recording.frames.end(),
            [](const RecordedFrame& a, const RecordedFrame& b) { return a.sequence < b.sequence; });
  if (!recording.frames.empty()) return recording;
  return Error{ErrorCode::kFormat, folder + ": holds no frame-NNNNNN.depth.png; is it a 7-Scenes sequence?"};
}

Expected<Recording> list_redwood(const std::string& folder, const ListOptions& options) {
  Expected<Recording> recording = list_numbered(folder, options);
  if (recording.ok()) recording->defaults = {{640, 480, 525.0F, 525.0F, 319.5F, 239.5F}, 1000};
  return recording;
}

Expected<Recording> list_sun3d(const std::string& folder, const ListOptions& options) {
  Expected<Recording> recording = list_numbered(folder, options);
  if (!recording) return recording;
  recording->rotated_bits = true;
  const Status status = read_intrinsics(folder + "/intrinsics.txt", &recording->defaults.camera);
  if (!status) return status.error();
  return recording;
}

}  // namespace loopsift
