// SPDX-License-Identifier: MIT
// NAME?key=value&key=value, taken apart.
#include <array>
#include <charconv>
#include <cmath>

#include "drivers/synth/synth_sequence.hpp"

namespace loopsift {
namespace {

constexpr const char* kKeys = "frames, laps, noise, distortion, seed, width, height, rate, color";
constexpr double kMaxPixels = 8192;

/// The whole text as a number from low to high.
bool number(const std::string& text, double low, double high, double* value) {
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), *value);
  return parsed.ec == std::errc() && parsed.ptr == text.data() + text.size() && *value >= low &&
         *value <= high;
}

/// One key, the range of its values, whether it is a whole number, and where it goes.
struct Key {
  const char* name;
  double low, high;
  bool whole;
  void (*set)(double value, SynthSettings* settings);
};

constexpr std::array<Key, 9> kTable = {{
    {"frames", 1, 1e6, true, [](double v, SynthSettings* s) { s->frames = static_cast<int>(v); }},
    {"laps", 1, 1e4, true, [](double v, SynthSettings* s) { s->laps = static_cast<int>(v); }},
    {"noise", 0, 1, true, [](double v, SynthSettings* s) { s->noise.noise = v != 0.0; }},
    {"distortion", 0, 1, true, [](double v, SynthSettings* s) { s->noise.distortion = v != 0.0; }},
    {"seed", 0, 9e15, true,
     [](double v, SynthSettings* s) { s->noise.seed = static_cast<std::uint64_t>(v); }},
    {"width", 16, kMaxPixels, true,
     [](double v, SynthSettings* s) { s->camera.width = static_cast<int>(v); }},
    {"height", 16, kMaxPixels, true,
     [](double v, SynthSettings* s) { s->camera.height = static_cast<int>(v); }},
    {"rate", 0.1, 1000, false, [](double v, SynthSettings* s) { s->rate_hz = v; }},
    {"color", 0, 1, true, [](double v, SynthSettings* s) { s->color = v != 0.0; }},
}};

Status apply(const std::string& scene, const std::string& item, SynthSettings* settings) {
  const std::size_t equals = item.find('=');
  const std::string name = item.substr(0, equals);
  for (const Key& key : kTable) {
    if (name != key.name) continue;
    double value = 0;
    const std::string text = equals == std::string::npos ? "" : item.substr(equals + 1);
    if (!number(text, key.low, key.high, &value) || (key.whole && value != std::floor(value)))
      return Error{ErrorCode::kUsage, "synth:" + scene + ": '" + item + "': " + name + " takes a " +
                                          (key.whole ? "whole " : "") + "number from " +
                                          std::to_string(static_cast<long long>(key.low)) + " to " +
                                          std::to_string(static_cast<long long>(key.high))};
    key.set(value, settings);
    return {};
  }
  return Error{ErrorCode::kUsage,
               "synth:" + scene + ": no key '" + name + "'; there are " + std::string(kKeys)};
}

/// Another image size sees the same field: intrinsics scale, pixel centres at integers.
void resize(int width, int height, PinholeCamera* camera) {
  const float sx = static_cast<float>(width) / static_cast<float>(camera->width);
  const float sy = static_cast<float>(height) / static_cast<float>(camera->height);
  *camera = {width,
             height,
             camera->fx * sx,
             camera->fy * sy,
             (camera->cx + 0.5F) * sx - 0.5F,
             (camera->cy + 0.5F) * sy - 0.5F};
}

/// Any member that is not 0 replaces the camera's own.
void override_camera(const PinholeCamera& given, PinholeCamera* camera) {
  if (given.fx != 0) camera->fx = given.fx;
  if (given.fy != 0) camera->fy = given.fy;
  if (given.cx != 0) camera->cx = given.cx;
  if (given.cy != 0) camera->cy = given.cy;
}

}  // namespace

Expected<SynthSettings> parse_synth_settings(const std::string& scene, const SourceOptions& options) {
  SynthSettings settings;
  settings.noise.seed = options.seed;
  if (options.depth_scale > 0) settings.noise.depth_unit_m = 1.0 / options.depth_scale;
  if (options.rate_hz > 0) settings.rate_hz = options.rate_hz;
  const PinholeCamera standard = settings.camera;
  if (options.camera.width > 0) settings.camera.width = options.camera.width;
  if (options.camera.height > 0) settings.camera.height = options.camera.height;
  const std::size_t question = scene.find('?');
  settings.name = scene.substr(0, question);
  for (std::size_t from = question; from != std::string::npos;) {
    const std::size_t to = scene.find('&', from + 1);
    const std::size_t length = to == std::string::npos ? to : to - from - 1;
    if (Status s = apply(scene, scene.substr(from + 1, length), &settings); !s) return s.error();
    from = to;
  }
  const int width = settings.camera.width, height = settings.camera.height;
  settings.camera = standard;
  resize(width, height, &settings.camera);
  override_camera(options.camera, &settings.camera);
  if (!settings.camera.is_valid())
    return Error{ErrorCode::kUsage,
                 "synth:" + scene + ": the camera needs positive width, height, fx and fy"};
  settings.color = settings.color && options.want_color;
  return settings;
}

}  // namespace loopsift
