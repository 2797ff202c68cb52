// SPDX-License-Identifier: MIT
// What can be asked of libcamera without a camera; with one: tests/system/guest.
#include "drivers/libcamera/libcamera_source.hpp"

#include <gmock/gmock.h>

namespace loopsift {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LibcameraSource, ACameraThatIsNotThereIsNotFoundAgainAndAgain) {
  for (const std::string which : {"no-such-camera", "9999", "", "-1"}) {
    const SourceOptions options;
    const auto source = open_libcamera(which, options);
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::kNotFound);
    EXPECT_THAT(source.error().message,
                AllOf(HasSubstr("libcamera:" + which), HasSubstr("loopsift-tool devices")));
  }
}

TEST(LibcameraSource, ListedCamerasCanBeNamed) {
  for (const DeviceInfo& device : list_libcamera_devices()) {
    EXPECT_THAT(device.uri, HasSubstr("libcamera:"));
    EXPECT_FALSE(device.name.empty());
  }
}

}  // namespace
}  // namespace loopsift
