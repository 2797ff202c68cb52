// SPDX-License-Identifier: MIT
// The drivers by name: those of this build, and those that another build may have. Set-up only.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/base/span.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/list_devices.hpp"

namespace loopsift {

struct Driver {
  using Open = Expected<std::unique_ptr<FrameSource>>(const std::string& address,
                                                      const SourceOptions& options);
  using List = std::vector<DeviceInfo>();

  const char* kind;   ///< what a URI begins with, before its colon
  const char* usage;  ///< its URIs, for a person
  Open* open;         ///< null: its library was not there when this program was built
  List* list;         ///< null: it has no devices that could be listed
};

/// All of them, as they are told to a person.
[[nodiscard]] Span<const Driver> drivers();

}  // namespace loopsift
