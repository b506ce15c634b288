#include "lcm_tools/process/arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/version.hpp"

namespace marco::process {
namespace {

using ::testing::AllOf;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Answer {
  std::optional<int> code;
  std::string out;
  std::string err;
};

// A program with an option, one with a limit, and one that is demanded; `log` has commands.
Answer give(std::vector<const char*> words) {
  CommandLine app("Makes something");
  double speed = 1.0;
  std::string out, input;
  app.add_option("--out", out);
  app.add_option("--speed", speed).between(0.0, 9.0);
  app.add_option("INPUT", input).required();
  words.insert(words.begin(), "/somewhere/marco-test");
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Answer answer;
  answer.code = app.parse(static_cast<int>(words.size()), words.data());
  std::fflush(stdout);
  answer.out = ::testing::internal::GetCapturedStdout();
  answer.err = ::testing::internal::GetCapturedStderr();
  return answer;
}

std::string mistake_with_commands(std::vector<const char*> words) {
  CommandLine app("Makes something", "marco-log");
  app.require_subcommand();
  bool json = false;
  app.add_subcommand("info", "says").add_flag("--json", json, "as JSON");
  app.add_subcommand("export", "writes");
  words.insert(words.begin(), "marco-log");
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(app.parse(static_cast<int>(words.size()), words.data()), Eq(kExitUsage));
  return ::testing::internal::GetCapturedStderr();
}

TEST(Arguments, WhatMakesSenseIsLetThrough) {
  EXPECT_EQ(give({"a.lcm", "--out", "there"}).code, std::nullopt);
}

TEST(Arguments, EveryMistakeOfTheCommandLineIsAUsageError) {
  for (const std::vector<const char*>& words :
       std::vector<std::vector<const char*>>{{},
                                             {"a", "b"},
                                             {"a", "--out"},
                                             {"a", "--speed", "10"},
                                             {"a", "--speed", "fast"},
                                             {"--nothing"}}) {
    const Answer answer = give(words);
    EXPECT_EQ(answer.code, kExitUsage);
    EXPECT_THAT(answer.err, AllOf(StartsWith("marco-test: "), HasSubstr("Try marco-test --help")));
    EXPECT_EQ(answer.out, "");
  }
}

TEST(Arguments, TheNearestNameIsSaidForAWordThatNobodyKnows) {
  // INPUT is missing, too, but that is not what the person got wrong
  EXPECT_THAT(give({"--otu=x"}).err, HasSubstr("unknown option '--otu'; did you mean '--out'?"));
  EXPECT_THAT(give({"a", "--zzz"}).err, HasSubstr("unknown option '--zzz'\n"));
  EXPECT_THAT(mistake_with_commands({"inof"}),
              HasSubstr("unknown command 'inof'; did you mean 'info'?"));
  EXPECT_THAT(mistake_with_commands({"info", "--jsn"}),
              HasSubstr("unknown option '--jsn'; did you mean '--json'?"));
  EXPECT_THAT(mistake_with_commands({}), HasSubstr("subcommand is required"));
}

TEST(Arguments, HelpAndVersionGoToStdoutAndEndWell) {
  const Answer help = give({"--help"});
  EXPECT_EQ(help.code, kExitDone);
  EXPECT_THAT(help.out, AllOf(HasSubstr("Usage: marco-test"), HasSubstr("--version")));
  const Answer version = give({"--version"});
  EXPECT_EQ(version.code, kExitDone);
  EXPECT_EQ(version.out, "marco-test " + process::version() + "\n");
  EXPECT_THAT(process::version(),
              ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+( \\([0-9a-f]+\\))?"));
}

TEST(RunMain, ExitCodesFollowTheTable) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_main("p", [] { return kExitDone; }), 0);
  EXPECT_EQ(run_main("p", []() -> int { throw std::runtime_error("no device"); }), 1);
  EXPECT_EQ(run_main("p", []() -> int { throw UsageError("give a log"); }), 2);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "p: no device\np: give a log\n");
}

}  // namespace
}  // namespace marco::process
