// SPDX-License-Identifier: MIT
// Images over LCM from another process; LCM's own thread, which puts each message together, is counted with
// the rest.
#include <lcm/lcm.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "core/base/steady_time.hpp"
#include "drivers/lcm/images_decoder.hpp"
#include "tests/bench/camera_load.hpp"
#include "tests/support/lcm_images.hpp"

namespace loopsift::bench {
namespace {

bot_core::images_t message(bool coded) {
  const Picture& room = picture();
  bot_core::images_t images = test::images(0, kWidth, kHeight, 1000, coded);
  const auto put = [](const std::vector<std::uint8_t>& bytes, bot_core::image_t* image) {
    image->data = bytes;
    image->size = static_cast<std::int32_t>(bytes.size());
  };
  put(coded ? test::zlib_bytes(room.depth) : test::raw_bytes(room.depth), &images.images[1]);
  put(coded ? test::jpeg_bytes(room.color) : test::raw_bytes(room.color), &images.images[0]);
  if (coded) images.images[0].pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
  return images;
}

// Sends until this process ends.
[[noreturn]] void send(const std::string& url, bot_core::images_t images) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  lcm_t* lcm = lcm_create(url.c_str());
  Pace pace;
  while (lcm != nullptr) {
    pace.wait();
    images.utime = steady_now_ns() / 1000;
    const std::vector<std::uint8_t> bytes = test::encode(images);
    (void)lcm_publish(lcm, "CAMERA", bytes.data(), static_cast<unsigned>(bytes.size()));
  }
  _exit(1);
}

double decoding_s(const bot_core::images_t& images) {
  const std::vector<std::uint8_t> bytes = test::encode(images);
  ImagesMessage parsed;
  if (parse_images({bytes.data(), bytes.size()}, &parsed) != nullptr) return 0;
  ImagesDecoder decoder(kWidth, kHeight);
  Picture out;
  return cost_s([&] {
    (void)decoder.decode_depth(parsed, out.depth.view());
    (void)decoder.decode_color(parsed.color, out.color.view());
  });
}

void load_messages(const std::string& name, bool coded) {
  const bot_core::images_t images = message(coded);
  SourceOptions options = usual_options();
  options.lcm_in.open_timeout_s = 5;
  const pid_t sender = fork();
  if (sender == 0) send(options.lcm_in.url, images);
  const auto source = open_source("lcm:CAMERA", options);
  if (source.ok())
    measure(name, **source, coded ? decoding_s(images) : 0, [] {});
  else
    print_skipped(name, source.error().message);
  kill(sender, SIGKILL);
  waitpid(sender, nullptr, 0);
}

}  // namespace

void load_lcm() {
  load_messages("lcm, raw", false);
  load_messages("lcm, zlib and JPEG", true);
}

}  // namespace loopsift::bench
