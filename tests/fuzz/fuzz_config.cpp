// SPDX-License-Identifier: MIT
// Any text as settings, as a camera file, and as one `--set` of the command line.
#include "firmware_app/camera_file.hpp"
#include "firmware_app/settings.hpp"
#include "tests/fuzz/input_file.hpp"

namespace {

// A camera file that the settings name would be any file of this computer, devices among them. (That none is
// named, as in the default settings, is no harm.)
bool names_a_file(const std::string& text) {
  for (std::size_t at = text.find("file"); at != std::string::npos; at = text.find("file", at + 1)) {
    const std::size_t equals = text.find_first_not_of(" \t\"'", at + 4);
    if (equals == std::string::npos || text[equals] != '=') continue;
    const std::size_t value = text.find_first_not_of(" \t", equals + 1);
    const bool none = value != std::string::npos && text.compare(value, 3, "\"\"\n") == 0;
    if (!none) return true;
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopsift;
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (names_a_file(text)) return 0;
  const fuzz::InputFile file(data, size);
  const auto settings = load_settings(file.path(), {text});
  if (settings.ok()) (void)to_toml(*settings);
  CameraCalibration calibration;
  std::vector<std::string> problems;
  (void)read_camera_file(file.path(), &calibration, &problems);
  return 0;
}
