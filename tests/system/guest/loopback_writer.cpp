// SPDX-License-Identifier: MIT
#include "tests/system/guest/loopback_writer.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>

namespace loopsift::test {

LoopbackWriter::LoopbackWriter(const std::string& path, int width, int height)
    : width_(width),
      height_(height),
      image_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return;
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  format.fmt.pix.width = static_cast<std::uint32_t>(width);
  format.fmt.pix.height = static_cast<std::uint32_t>(height);
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_Y16;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  format.fmt.pix.bytesperline = static_cast<std::uint32_t>(2 * width);
  format.fmt.pix.sizeimage = static_cast<std::uint32_t>(2 * width * height);
  if (::ioctl(fd, VIDIOC_S_FMT, &format) != 0 || format.fmt.pix.pixelformat != V4L2_PIX_FMT_Y16) {
    ::close(fd);
    return;
  }
  fd_ = fd;
  write_image(1);  // only then does the device offer its format to readers
  thread_ = std::thread([this] { run(); });
}

LoopbackWriter::~LoopbackWriter() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
  if (fd_ >= 0) ::close(fd_);
}

void LoopbackWriter::write_image(int number) {
  auto* pixel = image_.data();
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) *pixel++ = loopback_pixel(number, x, y);
  (void)!::write(fd_, image_.data(), 2 * image_.size());  // nobody reads: the image is lost, no matter
}

void LoopbackWriter::run() {
  for (int number = 2; !stopping_; ++number) {
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
    write_image(number);
  }
}

}  // namespace loopsift::test
