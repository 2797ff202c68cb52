// SPDX-License-Identifier: MIT
#include "tests/support/openni2_plugin/control.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace loopsift::test {
namespace {

// Calls visit(name, member) for each member.
template <class Control, class Visit>
void for_each_member(Control& c, Visit visit) {
  visit("film", c.film);
  visit("plugged", c.plugged);
  visit("busy", c.busy);
  visit("silent", c.silent);
  visit("repeat", c.repeat);
  visit("unplug_at_end", c.unplug_at_end);
  visit("can_register", c.can_register);
  visit("can_sync", c.can_sync);
  visit("mirrored", c.mirrored);
  visit("field_of_view_rad", c.field_of_view_rad);
  visit("rate_hz", c.rate_hz);
  visit("color_delay_ms", c.color_delay_ms);
  visit("color_every", c.color_every);
  visit("time_offset_s", c.time_offset_s);
}

}  // namespace

std::optional<CameraControl> CameraControl::find(const std::string& path) {
  CameraControl control;
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::string name;
  while (file >> name) {
    for_each_member(control, [&](const char* known, auto& member) {
      if (name == known) file >> member;
    });
  }
  return control;
}

std::optional<CameraControl> CameraControl::find() {
  const char* path = std::getenv(kControlVariable);
  return find(path != nullptr ? path : "");
}

void CameraControl::write(const std::string& path) const {
  const std::string draft = path + ".new";
  {
    std::ofstream file(draft);
    file.precision(17);
    for_each_member(*this,
                    [&](const char* name, const auto& value) { file << name << ' ' << value << '\n'; });
  }
  std::filesystem::rename(draft, path);
}

}  // namespace loopsift::test
