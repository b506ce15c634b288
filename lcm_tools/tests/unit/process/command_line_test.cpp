#include "lcm_tools/process/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

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

TEST(CommandLine, HelpIsFoldedInProseAndBelowEachDescription) {
  CommandLine app(
      "The first line of this text is longer than a hundred columns, and flows into the one that\n"
      "follows. This one is short.\n"
      "  an item of a list that is longer than a hundred columns, which the item after it does not "
      "continue;\n"
      "  another item");
  bool flag = false, hidden = false;
  app.add_flag(
      "--flag", flag,
      "What it means takes more than the seventy columns that stand beside the name of it");
  app.add_flag("--hidden", hidden, "not shown").hidden();
  const std::array<const char*, 2> words = {"marco-test", "--help"};
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(app.parse(2, words.data()), kExitDone);
  std::fflush(stdout);
  const std::string help = ::testing::internal::GetCapturedStdout();
  EXPECT_THAT(help, HasSubstr("does not\n  continue;\n  another item\n"));
  EXPECT_THAT(help, HasSubstr("beside\n                              the name of it\n  --version"));
  EXPECT_THAT(help, ::testing::Not(HasSubstr("hidden")));
}

TEST(CommandLine, WhatMakesSenseIsLetThrough) {
  EXPECT_EQ(give({"a.lcm", "--out", "there"}).code, std::nullopt);
}

TEST(CommandLine, EveryMistakeOfTheCommandLineIsAUsageError) {
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

TEST(CommandLine, TheNearestNameIsSaidForAWordThatNobodyKnows) {
  // INPUT is missing, too, but that is not what the person got wrong
  EXPECT_THAT(give({"--otu=x"}).err, HasSubstr("unknown option '--otu'; did you mean '--out'?"));
  EXPECT_THAT(give({"a", "--zzz"}).err, HasSubstr("unknown option '--zzz'\n"));
  EXPECT_THAT(mistake_with_commands({"inof"}),
              HasSubstr("unknown command 'inof'; did you mean 'info'?"));
  EXPECT_THAT(mistake_with_commands({"info", "--jsn"}),
              HasSubstr("unknown option '--jsn'; did you mean '--json'?"));
  EXPECT_THAT(mistake_with_commands({}), HasSubstr("subcommand is required"));
}

TEST(CommandLine, HelpAndVersionGoToStdoutAndEndWell) {
  const Answer help = give({"--help"});
  EXPECT_EQ(help.code, kExitDone);
  EXPECT_THAT(help.out, AllOf(HasSubstr("Usage: marco-test"), HasSubstr("--version")));
  const Answer version = give({"--version"});
  EXPECT_EQ(version.code, kExitDone);
  EXPECT_EQ(version.out, "marco-test " + process::version() + "\n");
  EXPECT_THAT(process::version(),
              ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+( \\([0-9a-f]+\\))?"));
}

TEST(CommandLine, AChoiceIsOneOfItsWords) {
  enum class Colour { red, green };
  const auto choose = [](const char* word, Colour& chosen) {
    CommandLine app("Paints", "marco-paint");
    app.add_choice<Colour>("--colour", chosen, {{"red", Colour::red}, {"green", Colour::green}},
                           "of the wall");
    const std::array<const char*, 3> words{"marco-paint", "--colour", word};
    return app.parse(words.size(), words.data());
  };
  Colour chosen = Colour::red;
  EXPECT_EQ(choose("green", chosen), std::nullopt);
  EXPECT_EQ(chosen, Colour::green);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(choose("blue", chosen), kExitUsage);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("blue not in {green,red}"));
  EXPECT_EQ(chosen, Colour::green);
}

TEST(CommandLine, AFlagThatEndsAsksForNothingElse) {
  CommandLine app("Lists", "marco-list");
  std::string input;
  bool is_listed = false;
  app.add_option("INPUT", input).required();
  app.add_flag_that_ends(
      "--list", [&] { is_listed = true; }, "lists, and is done");
  const std::array<const char*, 2> words{"marco-list", "--list"};
  EXPECT_EQ(app.parse(words.size(), words.data()), kExitDone);
  EXPECT_TRUE(is_listed);
}

}  // namespace
}  // namespace marco::process
