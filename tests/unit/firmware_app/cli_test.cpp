// SPDX-License-Identifier: MIT
#include "firmware_app/cli.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;
using Action = CommandLine::Action;

Expected<CommandLine> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "loopsift");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data());
}

std::string problem(const std::vector<const char*>& arguments) {
  const auto line = parse(arguments);
  EXPECT_FALSE(line.ok());
  if (line.ok()) return "";
  EXPECT_EQ(line.error().code, ErrorCode::kUsage);
  return line.error().message;
}

TEST(CommandLine, OptionsWithANameOfTheirOwnWinOverSetWhichWinsOverTheFile) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "file.toml";
  std::ofstream(path) << "[run]\nsource = 'synth:file'\nout = 'file'\nrate = 'max'\n[memory]\ncap_mib = 99\n";
  const auto line = parse({"--config", path.c_str(), "--set", "run.out=set", "--set", "run.source=synth:set",
                           "--source", "replay:tum:/data/a b"});
  ASSERT_TRUE(line.ok()) << line.error().message;
  EXPECT_EQ(line->action, Action::kRun);
  EXPECT_EQ(line->settings.run.source, "replay:tum:/data/a b");
  EXPECT_EQ(line->settings.run.out, "set");
  EXPECT_EQ(line->settings.run.rate, Rate::kMax);
  EXPECT_EQ(line->settings.memory.cap_mib, 99);
}

TEST(CommandLine, EveryOptionReachesItsSetting) {
  const auto line =
      parse({"--source=synth:room?frames=60", "--odometry", "file:t.txt", "--out", "o", "--rate", "max"});
  ASSERT_TRUE(line.ok()) << line.error().message;
  EXPECT_EQ(line->settings.run.source, "synth:room?frames=60");
  EXPECT_EQ(line->settings.run.odometry, "file:t.txt");
  EXPECT_EQ(line->settings.run.out, "o");
  EXPECT_EQ(line->settings.run.rate, Rate::kMax);
}

TEST(CommandLine, HelpAndVersionAreTexts) {
  const auto help = parse({"--help"});
  ASSERT_TRUE(help.ok());
  EXPECT_EQ(help->action, Action::kPrintText);
  for (const char* option :
       {"--config", "--source", "--odometry", "--out", "--rate", "--set", "--print-budget", "--check-config",
        "--version", "replay:7scenes:DIR", "Exit codes"})
    EXPECT_THAT(help->text, HasSubstr(option));
  const auto version = parse({"--version"});
  ASSERT_TRUE(version.ok());
  EXPECT_THAT(version->text, ::testing::MatchesRegex("loopsift [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(CommandLine, CheckConfigAndPrintBudgetNeedNoSource) {
  const auto check = parse({"--check-config"});
  ASSERT_TRUE(check.ok());
  EXPECT_EQ(check->action, Action::kPrintSettings);
  const auto budget = parse({"--print-budget"});
  ASSERT_TRUE(budget.ok());
  EXPECT_EQ(budget->action, Action::kPrintBudget);
}

TEST(CommandLine, BadUsageIsNamed) {
  EXPECT_THAT(problem({}), HasSubstr("no source"));
  EXPECT_THAT(problem({"--sauce", "x"}), HasSubstr("--sauce"));
  EXPECT_THAT(problem({"extra"}), HasSubstr("extra"));
  EXPECT_THAT(problem({"--source"}), HasSubstr("--source"));
  EXPECT_THAT(problem({"--source", "synth:room", "--rate", "fast"}), HasSubstr("--rate"));
  EXPECT_THAT(problem({"--config", "/no/such.toml"}), HasSubstr("/no/such.toml"));
  EXPECT_THAT(problem({"--source", "synth:room", "--odometry", "gps"}), HasSubstr("\"gps\""));
}

TEST(CommandLine, AllProblemsOfTheSettingsComeTogether) {
  const std::string message =
      problem({"--check-config", "--set", "camera.fz=1", "--set", "memory.cap_mib=little"});
  EXPECT_THAT(message, HasSubstr("camera.fz"));
  EXPECT_THAT(message, HasSubstr("memory.cap_mib"));
}

}  // namespace
}  // namespace loopsift
