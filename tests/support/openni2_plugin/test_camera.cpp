// SPDX-License-Identifier: MIT
#include "tests/support/openni2_plugin/test_camera.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mount.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "tests/support/openni2_plugin/film.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift::test {
namespace {

constexpr const char* kSettings = "/etc/openni2/OpenNI.ini";
constexpr std::uint16_t kNoDepthInRecordings = 65535;

class FilmWriter {
 public:
  FilmWriter(const std::string& path, int width, int height, bool has_color) : file_(path, std::ios::binary) {
    header_.width = static_cast<std::uint32_t>(width);
    header_.height = static_cast<std::uint32_t>(height);
    header_.has_color = has_color ? 1 : 0;
    put(&header_, sizeof header_);
  }
  void add(std::int64_t timestamp_us, const std::uint16_t* depth, const Rgb8* color) {
    put(&timestamp_us, sizeof timestamp_us);
    put(depth, header_.depth_bytes());
    put(color, header_.color_bytes());
    ++header_.frames;
  }
  void close() {
    file_.seekp(0);
    put(&header_, sizeof header_);
    file_.close();
    if (!file_) throw std::runtime_error("the film cannot be written");
  }

 private:
  void put(const void* bytes, std::size_t count) {
    file_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
  }
  std::ofstream file_;
  FilmHeader header_;
};

/// A mount namespace, with a user namespace around it where the rights for the first are missing.
bool enter_own_mounts() {
  if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
  return mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
}

/// As the onboard program does; why: drivers/openni2/session.hpp.
void make_stacks_small() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, std::size_t{512} << 10);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

bool show_plugin() {
  make_stacks_small();
  const TemporaryFolder folder;  // a mounted file stays when its name is gone
  const std::string settings = folder.write(
      "OpenNI.ini", std::string("[Log]\nVerbosity=3\nLogToConsole=0\nLogToFile=0\n[Device]\n[Drivers]\n") +
                        "Repository=" + LOOPSIFT_TEST_OPENNI2_DRIVERS + "\n");
  return enter_own_mounts() && mount(settings.c_str(), kSettings, nullptr, MS_BIND, nullptr) == 0;
}

}  // namespace

int write_film(FrameSource& source, int frames, const std::string& path) {
  const SourceInfo& info = source.info();
  FrameBuffers buffers(info);
  FilmWriter film(path, info.camera.width, info.camera.height, info.color_width != 0);
  int written = 0;
  while (written < frames && source.read(buffers.frame, 1000) == ReadStatus::kFrame) {
    const ImageView<std::uint16_t>& depth = buffers.frame.depth;
    std::replace(depth.data, depth.data + depth.size(), kNoDepthInRecordings, std::uint16_t{0});
    film.add(buffers.frame.timestamp_ns / 1000, buffers.frame.depth.data, buffers.frame.color.data);
    ++written;
  }
  film.close();
  return written;
}

void write_drawn_film(const std::string& path, int frames, int width, int height, bool with_color,
                      std::int64_t first_us) {
  FilmWriter film(path, width, height, with_color);
  for (int k = 0; k < frames; ++k) {
    film.add(first_us + k * 1'000'000LL / 30, make_depth(width, height, k).pixels.data(),
             make_color(width, height, k).pixels.data());
  }
  film.close();
}

bool TestCamera::install() {
  static const bool installed = show_plugin();
  return installed;
}

TestCamera::TestCamera() : control_path_(folder_ / "camera") {
  setenv(kControlVariable, control_path_.c_str(), 1);
  apply();
}

}  // namespace loopsift::test
