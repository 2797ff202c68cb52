// SPDX-License-Identifier: MIT
#include "drivers/v4l2/v4l2_uri.hpp"

#include <charconv>
#include <cmath>

#include "drivers/image_limits.hpp"

namespace loopsift {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find(separator, from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

template <class Number>
bool read_number(const std::string& text, Number most, Number* number) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end || !(value > 0) || value > most) return false;
  *number = value;
  return true;
}

// Null, or what is wrong.
const char* set(const std::string& key, const std::string& value, V4l2Options* options) {
  bool valid = true;
  if (key == "format") {
    options->format = value;
  } else if (key == "controls") {
    options->controls = split(value, ',');
  } else if (key == "width") {
    valid = read_number(value, kLargestSide, &options->width);
  } else if (key == "height") {
    valid = read_number(value, kLargestSide, &options->height);
  } else if (key == "buffers") {
    valid = read_number(value, V4l2Options::kMostBuffers, &options->buffers);
  } else if (key == "rate_hz") {
    valid = read_number(value, V4l2Options::kHighestRateHz, &options->rate_hz);
  } else {
    return "is no option; known are format, width, height, rate_hz, buffers and controls";
  }
  return valid ? nullptr : "is no number that makes sense here";
}

}  // namespace

Expected<V4l2Address> parse_v4l2_uri(const std::string& text, const V4l2Options& defaults) {
  const std::size_t question = std::min(text.find('?'), text.size());
  V4l2Address address{text.substr(0, question), defaults};
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorCode::kUsage, "source 'v4l2:" + text + "': " + what};
  };
  if (address.path.empty()) return wrong("expected a device node, as in v4l2:/dev/video0");
  if (question == text.size()) return address;
  for (const std::string& option : split(text.substr(question + 1), '&')) {
    const std::size_t equals = std::min(option.find('='), option.size());
    const std::string value = option.substr(std::min(equals + 1, option.size()));
    if (const char* problem = set(option.substr(0, equals), value, &address.options))
      return wrong("'" + option + "' " + problem);
  }
  return address;
}

}  // namespace loopsift
