// SPDX-License-Identifier: MIT
#include "drivers/list_devices.hpp"

#include <iterator>

#ifdef LOOPSIFT_HAVE_LIBCAMERA
#include "drivers/libcamera/libcamera_source.hpp"
#endif
#ifdef LOOPSIFT_HAVE_OPENNI2
#include "drivers/openni2/openni2_source.hpp"
#endif
#ifdef LOOPSIFT_HAVE_V4L2
#include "drivers/v4l2/v4l2_source.hpp"
#endif

namespace loopsift {

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> all;
  [[maybe_unused]] const auto add = [&](std::vector<DeviceInfo> devices) {
    all.insert(all.end(), std::make_move_iterator(devices.begin()), std::make_move_iterator(devices.end()));
  };
#ifdef LOOPSIFT_HAVE_OPENNI2
  add(list_openni2_devices());
#endif
#ifdef LOOPSIFT_HAVE_V4L2
  add(list_v4l2_devices());
#endif
#ifdef LOOPSIFT_HAVE_LIBCAMERA
  add(list_libcamera_devices());
#endif
  return all;
}

}  // namespace loopsift
