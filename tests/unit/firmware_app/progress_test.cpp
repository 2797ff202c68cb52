// SPDX-License-Identifier: MIT
#include "firmware_app/progress.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>

namespace loopsift {
namespace {

using ::testing::HasSubstr;

/// Runs `write` on a stream in memory and returns what it wrote.
template <class Write>
std::string captured(const Write& write) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* stream = open_memstream(&text, &size);
  write(stream);
  std::fclose(stream);
  std::string result(text, size);
  std::free(text);
  return result;
}

TEST(Progress, TheLineNamesEverything) {
  const ProgressState state{"mapping", 250, 1000, 8, 17, 3};
  EXPECT_EQ(progress_line(state, 31.24, 8),
            "mapping [##------] 250/1000 frames, 31.2 frames/s, 8 fragments, loops 3 of 17");
}

TEST(Progress, WithoutAKnownEndThereIsNoBar) {
  EXPECT_EQ(progress_line({"lost", 7, -1, 0, 0, 0}, 0, 8),
            "lost 7 frames, 0.0 frames/s, 0 fragments, loops 0 of 0");
}

TEST(Progress, MoreFramesThanAnnouncedFillTheBar) {
  EXPECT_THAT(progress_line({"mapping", 12, 10, 0, 0, 0}, 0, 4), HasSubstr("[####] 12/10"));
}

TEST(Progress, PlainOutputIsALineEveryFiveSeconds) {
  const std::string text = captured([](std::FILE* stream) {
    Progress progress(stream, false);
    for (int i = 0; i <= 110; ++i) progress.update({"mapping", i, 200, 0, 0, 0}, 0.1 * i);
    progress.finish({"mapping", 110, 200, 0, 0, 0}, 11.0);
  });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);  // near 5 s, near 10 s, end
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_THAT(text, HasSubstr("10.0 frames/s"));
}

TEST(Progress, ATerminalIsRedrawnInPlace) {
  const std::string text = captured([](std::FILE* stream) {
    Progress progress(stream, true);
    for (int i = 0; i <= 100; ++i) progress.update({"mapping", i, 200, 0, 0, 0}, 0.01 * i);
    progress.finish({"mapping", 100, 200, 0, 0, 0}, 1.0);
  });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  const auto redraws = std::count(text.begin(), text.end(), '\r');
  EXPECT_GE(redraws, 8);
  EXPECT_LE(redraws, 12);
}

TEST(ProgressLine, SaysWhatWentWrongOnceItDid) {
  ProgressState state;
  EXPECT_EQ(progress_line(state, 0, 10).find("dropped"), std::string::npos);
  EXPECT_EQ(progress_line(state, 0, 10).find("late"), std::string::npos);
  state.frames_dropped = 12;
  state.frames_late = 3;
  EXPECT_NE(progress_line(state, 0, 10).find(", 12 dropped, 3 late"), std::string::npos);
}

}  // namespace
}  // namespace loopsift
