// SPDX-License-Identifier: MIT
// What cameras are there.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "drivers/list_devices.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

int list(const std::string& json_path) {
  const std::vector<DeviceInfo> devices = list_devices();
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const DeviceInfo& device : devices) {
    std::printf("%s  %s\n", device.uri.c_str(), device.name.c_str());
    for (const std::string& format : device.formats) std::printf("    %s\n", format.c_str());
    json.push_back({{"uri", device.uri}, {"name", device.name}, {"formats", device.formats}});
  }
  if (devices.empty()) std::printf("no camera is connected that a driver of this build sees\n");
  const Status written = write_json(json_path, json);
  return written.ok() ? kExitDone : fail(written.error());
}

}  // namespace

void add_devices_command(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "devices", "Lists the cameras that are connected: what --source takes, name, and image formats");
  const auto json = std::make_shared<std::string>();
  command->add_option("--json", *json, "Also write the list to this file")->type_name("FILE");
  command->callback([json, exit_code] { *exit_code = list(*json); });
}

}  // namespace loopsift::tool
