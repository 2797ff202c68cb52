// SPDX-License-Identifier: MIT
// Parts of the real-time threads one by one under the trap, and the back thread against its limit.
#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "drivers/replay/color_image.hpp"
#include "drivers/replay/image_file.hpp"
#include "firmware_app/back_worker.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;

// --- capture: decoders ---

struct Picture {
  Picture() : pixels(kWidth * kHeight) {
    for (std::size_t k = 0; k < pixels.size(); ++k)
      pixels[k] = {static_cast<std::uint8_t>(k % kWidth), static_cast<std::uint8_t>(2 * (k / kWidth)), 77};
  }
  static constexpr int kWidth = 96, kHeight = 64;
  [[nodiscard]] ImageView<const Rgb8> view() const { return {pixels.data(), kWidth, kHeight}; }
  [[nodiscard]] ImageView<Rgb8> view() { return {pixels.data(), kWidth, kHeight}; }
  std::vector<Rgb8> pixels;
};

class ColorDecoding : public ::testing::TestWithParam<const char*> {
 protected:
  std::string written() {
    const Picture picture;
    const std::string path = folder_ / GetParam();
    const Status status = std::string(GetParam()) == "png" ? write_png_rgb(path, picture.view())
                                                           : write_jpeg(path, picture.view(), 95);
    EXPECT_TRUE(status.ok());
    return path;
  }
  test::TemporaryFolder folder_;
};

TEST_P(ColorDecoding, MakesNoHeapCall) {
  const std::string path = written();
  ImageReader reader({Picture::kWidth, Picture::kHeight}, {Picture::kWidth, Picture::kHeight});
  Picture read;
  std::atomic<std::int64_t> calls{0};
  const char* problem = nullptr;
  {
    const HeapSeal seal(&calls, HeapMode::kCount);
    for (int k = 0; k < 20 && problem == nullptr; ++k) problem = reader.read_color(path, read.view());
  }
  EXPECT_EQ(problem, nullptr) << problem;
  EXPECT_EQ(calls, 0);
  const Picture original;
  double error = 0;
  for (std::size_t k = 0; k < read.pixels.size(); ++k)
    error += std::abs(read.pixels[k].g - original.pixels[k].g);
  EXPECT_LT(error / static_cast<double>(read.pixels.size()), 4.0);
}

TEST_P(ColorDecoding, ACutFileIsRefusedAndTheNextOneIsRead) {
  const std::string path = written();
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  ColorDecoder decoder(Picture::kWidth, Picture::kHeight);
  Picture read;
  for (std::size_t size = 8; size + 16 < bytes.size(); size += bytes.size() / 13)
    EXPECT_NE(decoder.decode({data, size}, read.view()), nullptr) << size;
  EXPECT_EQ(decoder.decode({data, bytes.size()}, read.view()), nullptr);
  const ImageView<Rgb8> smaller(read.pixels.data(), Picture::kWidth / 2, Picture::kHeight);
  EXPECT_STREQ(decoder.decode({data, bytes.size()}, smaller), "the image has another size than the camera");
}

INSTANTIATE_TEST_SUITE_P(Formats, ColorDecoding, ::testing::Values("png", "jpg"));

// --- back: past its limit ---

LcmSettings silent() {
  LcmSettings settings;
  settings.enabled = false;
  return settings;
}

struct BackParts {
  BackParts(std::int64_t heap_bytes, Arena& arena)
      : store({8, 200000, 64, 64, 4800}, arena),
        back_end(options(), arena),
        publisher(silent(), arena),
        worker(back_end, store, publisher, arena, limited(heap_bytes)) {}
  static BackWorkerOptions limited(std::int64_t heap_bytes) {
    BackWorkerOptions made;
    made.heap_bytes = heap_bytes;
    return made;
  }
  static BackEndOptions options() {
    BackEndOptions made;
    made.posterior.max_fragments = made.proposal.max_fragments = 8;
    return made;
  }
  FragmentStore store;
  BackEnd back_end;
  Publisher publisher;
  BackWorker worker;
};

TEST(BackThread, PastItsLimitIsDisabledAndHoldsNobodyUp) {
  const FragmentWorld world;
  const InArena<BackParts> parts(std::int64_t{16} << 10);
  parts->worker.start();
  for (const Fragment& fragment : world.fragments()) {
    ASSERT_NE(parts->store.add(fragment), nullptr);
    parts->worker.submit(fragment.frames[3].timestamp_ns);
  }
  parts->worker.wait_until_idle();
  EXPECT_TRUE(parts->worker.disabled());
  EXPECT_GT(parts->worker.heap_figures().refusals, 0);
  EXPECT_LE(parts->worker.heap_figures().peak_bytes, 16 << 10);
  CorrectionRecord correction;
  EXPECT_FALSE(parts->worker.take(&correction));
  parts->worker.finish();
  EXPECT_TRUE(parts->worker.ended());
}

TEST(BackThread, WithinItsLimitIsNotHeldUp) {
  const FragmentWorld world;
  const InArena<BackParts> parts(std::int64_t{64} << 20);
  parts->worker.start();
  for (const Fragment& fragment : world.fragments()) {
    ASSERT_NE(parts->store.add(fragment), nullptr);
    parts->worker.submit(fragment.frames[3].timestamp_ns);
  }
  parts->worker.finish();
  EXPECT_FALSE(parts->worker.disabled());
  EXPECT_EQ(parts->worker.heap_figures().refusals, 0);
  EXPECT_GT(parts->worker.heap_figures().peak_bytes, 0);
  EXPECT_EQ(parts->back_end.fragment_count(), 7);
}

}  // namespace
}  // namespace loopsift
