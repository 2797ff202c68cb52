// SPDX-License-Identifier: MIT
// The binding itself, on a small struct with a member of every type.
#include "firmware_app/option_table.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

enum class Colour { kRed, kGreen };

struct Nested {
  struct Inner {
    float gain = 0.5F;
  } inner;
  bool on = false;
  int count = 3;
  double length_m = 1.25;
  std::string name = "a \"b\"";
  std::vector<std::string> list = {"x=1", "y \"z\""};
  Colour colour = Colour::kRed;
};

OptionTable bind(Nested& n) {
  return {{"outer",
           "Outer.",
           {{"on", &n.on, "switch"},
            {"count", &n.count, "how many", {1, 10}},
            {"length_m", &n.length_m, "length"},
            {"name", &n.name, "a name"},
            {"list", &n.list, "some names"},
            {"colour", by_name(&n.colour, {{"red", Colour::kRed}, {"green", Colour::kGreen}}), "which"}}},
          {"outer.inner", "Inner.", {{"gain", &n.inner.gain, "gain", {0, 1}}}}};
}

class OptionTableTest : public ::testing::Test {
 protected:
  bool read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_toml_file(path_, bind(n_), &problems_);
  }
  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "options.toml";
  Nested n_;
  std::vector<std::string> problems_;
};

TEST_F(OptionTableTest, EveryTypeIsRead) {
  ASSERT_TRUE(
      read("[outer]\non = true\ncount = 7\nlength_m = 2\nname = 'x'\ncolour = \"green\"\n"
           "[outer.inner]\ngain = 0.25\n"));
  EXPECT_TRUE(n_.on);
  EXPECT_EQ(n_.count, 7);
  EXPECT_EQ(n_.length_m, 2.0);  // a whole number where a real one is wanted
  EXPECT_EQ(n_.name, "x");
  EXPECT_EQ(n_.colour, Colour::kGreen);
  EXPECT_EQ(n_.inner.gain, 0.25F);
}

TEST_F(OptionTableTest, AListOfStringsIsReadWrittenAndAssigned) {
  ASSERT_TRUE(read("[outer]\nlist = ['a', 'b=2']\n"));
  EXPECT_THAT(n_.list, ElementsAre("a", "b=2"));
  const std::string text = to_toml(bind(n_));
  EXPECT_THAT(text, HasSubstr("list = [\"a\", \"b=2\"]\n"));
  ASSERT_TRUE(assign("outer.list=[]", bind(n_), &problems_));
  EXPECT_THAT(n_.list, ElementsAre());
  EXPECT_THAT(to_toml(bind(n_)), HasSubstr("list = []\n"));
}

TEST_F(OptionTableTest, AListOfAnythingElseIsRefused) {
  for (const std::string wrong : {"'a'", "[1, 2]", "['a', 1]", "{}"}) {
    problems_.clear();
    EXPECT_FALSE(read("[outer]\nlist = " + wrong + "\n")) << wrong;
    EXPECT_THAT(problems_, ElementsAre(HasSubstr("expected a list of strings"))) << wrong;
  }
}

TEST_F(OptionTableTest, AnEmptyFileKeepsTheDefaults) {
  ASSERT_TRUE(read(""));
  EXPECT_EQ(n_.count, 3);
}

TEST_F(OptionTableTest, AllProblemsAreReportedTogetherWithTheirLines) {
  EXPECT_FALSE(
      read("[outer]\ncuont = 1\non = 1\ncount = 2.5\nname = 3\ncolour = 'blue'\n[inner]\ngain = 0.5\n"
           "[outer.inner]\ngain = 2\n"));
  EXPECT_THAT(problems_, ::testing::UnorderedElementsAre(
                             path_ + ":2: outer.cuont: there is no such key; the nearest is outer.count",
                             path_ + ":3: outer.on: expected true or false",
                             path_ + ":4: outer.count: expected a whole number",
                             path_ + ":5: outer.name: expected a string in quotes",
                             path_ + ":6: outer.colour: expected one of \"red\", \"green\"",
                             path_ + ":8: inner.gain: there is no such key; the nearest is outer.inner.gain",
                             path_ + ":10: outer.inner.gain: 2 is out of range: 0 to 1"));
}

TEST_F(OptionTableTest, AValueWhereATableBelongsIsAnError) {
  EXPECT_FALSE(read("outer = 3\n"));
  EXPECT_THAT(problems_, ElementsAre(HasSubstr(":1: outer: there is no such key")));
}

TEST_F(OptionTableTest, NumbersMustBeFiniteAndFit) {
  EXPECT_FALSE(read("[outer]\ncount = 5000000000\nlength_m = nan\n"));
  EXPECT_THAT(problems_, ElementsAre(HasSubstr("count: is too large a number"), HasSubstr("finite")));
}

TEST_F(OptionTableTest, SyntaxErrorsNameTheLine) {
  EXPECT_FALSE(read("[outer]\ncount = = 3\n"));
  EXPECT_THAT(problems_, ElementsAre(HasSubstr(path_ + ":2: is not TOML")));
}

TEST_F(OptionTableTest, AMissingFileOrAFolderIsNamed) {
  EXPECT_FALSE(read_toml_file("/no/such.toml", bind(n_), &problems_));
  EXPECT_FALSE(read_toml_file(folder_.path(), bind(n_), &problems_));
  EXPECT_THAT(problems_,
              ElementsAre(HasSubstr("/no/such.toml: cannot be read"), HasSubstr("cannot be read")));
}

TEST_F(OptionTableTest, AssignmentsTakeBareTextForStringsAndNames) {
  const OptionTable table = bind(n_);
  EXPECT_TRUE(assign("outer.name=udpm://a?b=c", table, &problems_));
  EXPECT_EQ(n_.name, "udpm://a?b=c");
  EXPECT_TRUE(assign("outer.name=12", table, &problems_));
  EXPECT_EQ(n_.name, "12");
  EXPECT_TRUE(assign("outer.name=\"quoted\"", table, &problems_));
  EXPECT_EQ(n_.name, "quoted");
  EXPECT_TRUE(assign("outer.name=", table, &problems_));
  EXPECT_EQ(n_.name, "");
  EXPECT_TRUE(assign("outer.colour=green", table, &problems_));
  EXPECT_EQ(n_.colour, Colour::kGreen);
  EXPECT_TRUE(assign("outer.inner.gain=1", table, &problems_));
  EXPECT_EQ(n_.inner.gain, 1.0F);
}

TEST_F(OptionTableTest, BadAssignmentsAreProblems) {
  const OptionTable table = bind(n_);
  EXPECT_FALSE(assign("outer.count", table, &problems_));
  EXPECT_FALSE(assign("outer.count=many", table, &problems_));
  EXPECT_FALSE(assign("outer.kount=1", table, &problems_));
  EXPECT_THAT(problems_, ElementsAre("--set outer.count: expected section.key=value",
                                     "--set outer.count=many: outer.count: expected a whole number",
                                     HasSubstr("the nearest is outer.count")));
  EXPECT_EQ(n_.count, 3);
}

TEST_F(OptionTableTest, PrintedSettingsReadBackEqual) {
  n_.length_m = 0.1;
  n_.inner.gain = 0.1F;
  n_.name = "tab\t \"quote\" \\ end";
  n_.colour = Colour::kGreen;
  const std::string text = to_toml(bind(n_));
  EXPECT_THAT(text, HasSubstr("# how many (1 to 10)\ncount = 3\n"));
  EXPECT_THAT(text, HasSubstr("gain = 0.1\n"));
  const Nested before = n_;
  n_ = Nested{};
  ASSERT_TRUE(read(text)) << problems_.front();
  EXPECT_EQ(n_.length_m, before.length_m);
  EXPECT_EQ(n_.inner.gain, before.inner.gain);
  EXPECT_EQ(n_.name, before.name);
  EXPECT_EQ(n_.colour, before.colour);
}

}  // namespace
}  // namespace loopsift
