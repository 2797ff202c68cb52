// SPDX-License-Identifier: MIT
#include "core/base/text_file.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

TEST(TextFile, SkipsCommentsAndBlanksAndCountsLines) {
  const test::TemporaryFolder folder;
  auto file = TextFile::open(folder.write("a.txt", "# head\n\n one\ttwo \r\n  # more\nthree"));
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE(file->next());
  ASSERT_EQ(file->words().size(), 2U);
  EXPECT_EQ(file->words()[1], "two");
  EXPECT_EQ(file->where(), folder / "a.txt" + ":3");
  ASSERT_TRUE(file->next());
  EXPECT_EQ(file->words()[0], "three");
  EXPECT_EQ(file->error("bad").message, folder / "a.txt" + ":5: bad");
  EXPECT_FALSE(file->next());
}

TEST(TextFile, NumbersMustBeWholeWordsAndFinite) {
  double d = 0;
  EXPECT_TRUE(parse_number("-1.5e-3", &d));
  EXPECT_DOUBLE_EQ(d, -1.5e-3);
  EXPECT_TRUE(parse_number("+2", &d));
  EXPECT_DOUBLE_EQ(d, 2);
  for (const char* bad : {"", "1,5", "1.5m", "nan", "inf", "1e999", "+"})
    EXPECT_FALSE(parse_number(bad, &d)) << bad;
  int i = 0;
  EXPECT_TRUE(parse_number("-12", &i));
  EXPECT_EQ(i, -12);
  for (const char* bad : {"1.5", "99999999999", "0x10"}) EXPECT_FALSE(parse_number(bad, &i)) << bad;
}

TEST(TextFile, SecondsKeepEveryNanosecond) {
  std::int64_t ns = 0;
  ASSERT_TRUE(parse_seconds("1305031102.175304", &ns));
  EXPECT_EQ(ns, 1305031102175304000);
  ASSERT_TRUE(parse_seconds("0.1234567891", &ns));
  EXPECT_EQ(ns, 123456789);
  ASSERT_TRUE(parse_seconds("12", &ns));
  EXPECT_EQ(ns, 12000000000);
  ASSERT_TRUE(parse_seconds("-1.5", &ns));
  EXPECT_EQ(ns, -1500000000);
  for (const char* bad : {"", "abc", "1.2x", "1.0000000000x", "99999999999.0"})
    EXPECT_FALSE(parse_seconds(bad, &ns)) << bad;
}

}  // namespace
}  // namespace loopsift
