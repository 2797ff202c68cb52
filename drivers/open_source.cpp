// SPDX-License-Identifier: MIT
#include <algorithm>

#include "drivers/assemble_source.hpp"
#include "drivers/driver_table.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/paired_source.hpp"

namespace loopsift {
namespace {

std::string available() {
  std::string text;
  for (const Driver& driver : drivers()) {
    if (driver.open != nullptr) text += (text.empty() ? "" : ", ") + std::string(driver.usage);
  }
  return text;
}

// KIND:ADDRESS; all of it is the kind where there is no colon.
Expected<std::unique_ptr<FrameSource>> open_driver(const std::string& uri, const SourceOptions& options) {
  const std::size_t colon = std::min(uri.find(':'), uri.size());
  const std::string kind = uri.substr(0, colon);
  const std::string address = colon < uri.size() ? uri.substr(colon + 1) : "";
  for (const Driver& driver : drivers()) {
    if (kind != driver.kind) continue;
    if (driver.open != nullptr) return driver.open(address, options);
    return Error{ErrorCode::kUnsupported,
                 "source '" + uri + "': this build has no " + kind + " driver; available are " + available()};
  }
  return Error{ErrorCode::kUsage,
               "source '" + uri + "': unknown kind '" + kind + "'; known are " + available()};
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_source(const std::string& uri, const SourceOptions& options) {
  auto source = open_driver(uri, depth_options(options));
  if (source.ok() && !options.color_source.empty()) {
    auto color = open_driver(options.color_source, color_options(options));
    if (!color) return Error{color.error().code, "camera.color_source: " + color.error().message};
    source = PairedSource::create(std::move(*source), std::move(*color));
  }
  if (!source) return source.error();
  return calibrate(std::move(*source), options.calibration);
}

}  // namespace loopsift
