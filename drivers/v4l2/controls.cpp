// SPDX-License-Identifier: MIT
#include "drivers/v4l2/controls.hpp"

#include <linux/videodev2.h>

#include <cctype>
#include <charconv>
#include <cstring>
#include <optional>

namespace loopsift {
namespace {

struct Control {
  std::uint32_t id;
  std::string name;  // "exposure_auto"
  std::int32_t min, max;
};

// "Exposure, Auto" → "exposure_auto": letters and digits, what is between them one underscore.
std::string slug(const char* name) {
  std::string text;
  for (; *name != '\0'; ++name) {
    const auto letter = static_cast<unsigned char>(*name);
    if (std::isalnum(letter) != 0) {
      text += static_cast<char>(std::tolower(letter));
    } else if (!text.empty() && text.back() != '_') {
      text += '_';
    }
  }
  while (!text.empty() && text.back() == '_') text.pop_back();
  return text;
}

bool can_be_set(const v4l2_queryctrl& query) {
  const bool number = query.type == V4L2_CTRL_TYPE_INTEGER || query.type == V4L2_CTRL_TYPE_BOOLEAN ||
                      query.type == V4L2_CTRL_TYPE_MENU || query.type == V4L2_CTRL_TYPE_INTEGER_MENU ||
                      query.type == V4L2_CTRL_TYPE_BUTTON || query.type == V4L2_CTRL_TYPE_BITMASK;
  return number && (query.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) == 0;
}

std::vector<Control> list_controls(const VideoDevice& device) {
  std::vector<Control> controls;
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (device.ioctl(VIDIOC_QUERYCTRL, &query) >= 0) {
    char name[sizeof query.name + 1] = {};
    std::memcpy(name, query.name, sizeof query.name);
    if (can_be_set(query)) controls.push_back({query.id, slug(name), query.minimum, query.maximum});
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return controls;
}

// Decimal, or hexadecimal after 0x.
template <class Number>
std::optional<Number> to_number(const std::string& text) {
  const bool hexadecimal = text.compare(0, 2, "0x") == 0;
  const char* const end = text.data() + text.size();
  Number value = 0;
  const auto read = std::from_chars(text.data() + (hexadecimal ? 2 : 0), end, value, hexadecimal ? 16 : 10);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return value;
}

const Control* find(const std::vector<Control>& controls, const std::string& name) {
  const std::optional<std::uint32_t> id = to_number<std::uint32_t>(name);
  for (const Control& control : controls)
    if (control.name == name || control.id == id) return &control;
  return nullptr;
}

std::string joined_names(const std::vector<Control>& controls) {
  std::string text;
  for (const Control& control : controls) text += (text.empty() ? "" : ", ") + control.name;
  return text.empty() ? "none" : text;
}

Status set_control(const VideoDevice& device, const std::vector<Control>& controls,
                   const std::string& assignment) {
  const std::string where = "control '" + assignment + "'";
  const std::size_t equals = assignment.find('=');
  const std::optional<std::int32_t> value =
      equals == std::string::npos ? std::nullopt : to_number<std::int32_t>(assignment.substr(equals + 1));
  if (!value) return device.error(ErrorCode::kUsage, where + ": expected name=whole number");
  const Control* control = find(controls, assignment.substr(0, equals));
  if (control == nullptr) {
    return device.error(ErrorCode::kUsage,
                        where + ": the device has no such control; it has " + joined_names(controls));
  }
  if (*value < control->min || *value > control->max) {
    return device.error(ErrorCode::kUsage, where + ": the device takes " + std::to_string(control->min) +
                                               " to " + std::to_string(control->max));
  }
  v4l2_control setting{control->id, *value};
  if (const int result = device.ioctl(VIDIOC_S_CTRL, &setting); result < 0)
    return device.system_error(where + " cannot be set", result);
  return {};
}

}  // namespace

Status set_controls(const VideoDevice& device, const std::vector<std::string>& assignments) {
  if (assignments.empty()) return {};
  const std::vector<Control> controls = list_controls(device);
  for (const std::string& assignment : assignments)
    if (Status set = set_control(device, controls, assignment); !set) return set;
  return {};
}

}  // namespace loopsift
