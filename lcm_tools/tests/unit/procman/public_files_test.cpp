// What stands in the procman files that people have written in twelve years, construct by
// construct.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/exec_line.hpp"
#include "lcm_tools/procman/script_runner.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string refusal(const std::string& text) {
  try {
    parse_config(text, "robot.pmd");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(PublicFiles, OneIdMayStandInTwoGroupsAndTwiceInOne) {
  Config config = parse_config(R"text(
group "left" { cmd "conduit" { exec = "a"; host = "one"; } }
group "right" {
  cmd "conduit" { exec = "b"; host = "two"; }
  cmd "conduit" { exec = "c"; host = "two"; }
  cmd "conduit (2)" { exec = "d"; host = "two"; }
}
script "all" { start cmd "conduit"; }
script "one" { start cmd "conduit (2)"; }
)text",
                               "robot.pmd");
  const auto warnings = make_ids_unique(config);
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_THAT(warnings[0], HasSubstr("robot.pmd:4:3: there is a command \"conduit\" at "
                                     "robot.pmd:2:16 already; this one is called \"conduit (3)\""));
  EXPECT_THAT(find_mistakes(config), IsEmpty());
  EXPECT_THAT(find_script_mistakes(config), IsEmpty());
  SheriffState sheriff("me");
  sheriff.load(config);
  ASSERT_THAT(sheriff.commands(), SizeIs(4)) << "each can be controlled";
  EXPECT_EQ(sheriff.commands().at("conduit (4)").spec.exec, "c");
  EXPECT_EQ(sheriff.commands().at("conduit (4)").spec.group, "right");
  EXPECT_THAT(sheriff.commands_of({TargetKind::command, "conduit"}),
              ElementsAre("conduit", "conduit (3)", "conduit (4)"));
  EXPECT_THAT(sheriff.commands_of({TargetKind::command, "conduit (2)"}),
              ElementsAre("conduit (2)"));
  Config again = parse_config(print_config(config), "saved.pmd");
  make_ids_unique(again);
  EXPECT_EQ(again, config) << "saved, it says what it said";
}

TEST(PublicFiles, AScriptThatNamesSomethingMissingIsTheOnlyOneRefused) {
  const Config config = parse_config(R"(
cmd "lidar" { exec = "x"; host = "one"; }
script "good" { start cmd "lidar"; }
script "command" { start cmd "lidar"; stop cmd "gone"; }
script "group" { start group "core" wait "running"; }
script "script" { run_script "gone too"; }
script "calls" { run_script "command"; }
)",
                                     "robot.pmd");
  EXPECT_THAT(find_mistakes(config), IsEmpty());
  const auto mistakes = find_script_mistakes(config);
  ASSERT_THAT(mistakes, SizeIs(4));
  EXPECT_THAT(mistakes.at("command"),
              ElementsAre("robot.pmd:4:39: expected a command of this file, got \"gone\""));
  EXPECT_THAT(mistakes.at("group"), ElementsAre(HasSubstr("expected a group of this file")));
  EXPECT_THAT(mistakes.at("script"), ElementsAre(HasSubstr("expected a script of this file")));
  EXPECT_THAT(mistakes.at("calls"),
              ElementsAre("robot.pmd:7:18: expected a script that can be run, got \"command\""));
  EXPECT_NO_THROW(ScriptRunner(config, "good"));
  EXPECT_THAT([&] { ScriptRunner(config, "command"); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("robot.pmd:4:39")));
}

TEST(PublicFiles, ABackslashAtTheLinesEndContinuesAString) {
  for (const std::string end : {"\n", "\r\n"}) {
    const Config config =
        parse_config("cmd \"a\" { exec = \"run --one \\" + end + "    --two\"; host = \"h\"; }" +
                         end + "cmd \"b\" { exec = \"x\"; host = \"h\"; }",
                     "f");
    const CommandConfig& command = config.root.commands.at(0);
    EXPECT_EQ(command.exec, "run --one \n    --two");
    EXPECT_THAT(split_words(command.wire_exec()), ElementsAre("run", "--one", "--two"));
    EXPECT_EQ(config.root.commands.at(1).place.line, 3);
  }
}

// Both public sheriffs take a bare line end in a string for a forgotten quote.
TEST(PublicFiles, WhatIsBrokenIsRefusedWithItsPlaceAndWhatWasExpected) {
  EXPECT_THAT(
      refusal("cmd \"a\" { exec = \"run\n --two\"; host = \"h\"; }"),
      HasSubstr("robot.pmd:1:18: this string does not end: expected '\"' on the same line"));
  EXPECT_THAT(refusal("cmd \"a\" { exec = \"x\\"), HasSubstr("does not end"));
  EXPECT_THAT(refusal("group \"g\" {\n<<<<<<< HEAD\n}"), HasSubstr("robot.pmd:2:1: expected"));
  EXPECT_THAT(refusal("=======\n"), HasSubstr("robot.pmd:1:1: expected"));
  EXPECT_THAT(refusal("cmd \"a\" {\n  exect = \"x\";\n}"),
              HasSubstr("robot.pmd:2:3: expected exec, deputy, host"));
  EXPECT_THAT(refusal("cmd \"w/driving\" { exec = \"x\"; host = \"h\"; }"),
              HasSubstr("robot.pmd:1:5: expected a command id without '/'"));
  EXPECT_THAT(refusal("cmd \"a\" { exec = \"x\"; host = \"h\"; }\n\t cmd \"b\" { exec }"),
              HasSubstr("robot.pmd:2:18: expected '=', got '}'"));
}

TEST(PublicFiles, BothWordsForTheDeputyLoad) {
  const Config config = parse_config(
      "cmd \"a\" { exec = \"x\"; host = \"h\"; }\ncmd \"b\" { exec = \"x\"; deputy = \"d\"; "
      "stop_signal = 9; }",
      "f");
  EXPECT_EQ(config.root.commands[0].deputy, "h");
  EXPECT_EQ(config.root.commands[1].deputy, "d");
  EXPECT_THAT(find_mistakes(config), IsEmpty());
}

/// Processor time of this thread.
double cpu_s() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Parsed and checked, with the processor time below `limit_s`.
void expect_cheap(const std::string& text, double limit_s) {
  const double before_s = cpu_s();
  Config config = parse_config(text, "f");
  make_ids_unique(config);
  find_mistakes(config);
  const auto mistakes = find_script_mistakes(config);
  if (!config.scripts.empty() && !mistakes.contains(config.scripts.front().name)) {
    ScriptRunner runner(config, config.scripts.front().name);
    SheriffState sheriff("me");
    runner.channels();
    runner.step(sheriff, 0);
  }
  EXPECT_LT(cpu_s() - before_s, limit_s);
}

// Seen here, without sanitizers: 0.01 to 0.2 s each; before, 2 s to more than 25 s.
TEST(ExplodingFiles, ScriptsThatRunScriptsCostWhatTheyAreLong) {
  std::string chain;
  for (int i = 0; i < 4000; ++i) {
    chain +=
        "script \"" + std::to_string(i) + "\" { run_script \"" + std::to_string(i + 1) + "\"; }\n";
  }
  expect_cheap(chain + "script \"4000\" { wait ms 1; }", 2.0);
  std::string pyramid;
  for (int i = 0; i < 300; ++i) {
    pyramid += "script \"" + std::to_string(i) + "\" { wait ms 0;";
    for (int k = i + 1; k < 300; ++k) pyramid += " run_script \"" + std::to_string(k) + "\";";
    pyramid += " }\n";
  }
  expect_cheap(pyramid, 5.0);
}

// Each runs the one before twice: 3 * 2^n - 2 actions.
TEST(ExplodingFiles, ScriptsWithMoreActionsThanAnybodyMeansAreRefused) {
  std::string text = "script \"0\" { wait ms 0; }\n";
  for (int i = 1; i < 60; ++i) {
    const std::string run = "run_script \"" + std::to_string(i - 1) + "\"; ";
    text += "script \"" + std::to_string(i) + "\" { " + run + run + "}\n";
  }
  const Config config = parse_config(text, "f");
  auto mistakes = find_script_mistakes(config);
  EXPECT_THAT(mistakes, SizeIs(44));
  EXPECT_THAT(mistakes["16"], Contains(HasSubstr("f:17:1: expected at most 100000 actions")));
  EXPECT_THAT(mistakes["59"], Contains(HasSubstr("script that can be run, got \"58\"")));
  EXPECT_THROW(ScriptRunner(config, "59"), std::invalid_argument);
  ScriptRunner longest(config, "15");
  SheriffState sheriff("me");
  int steps = 1;
  while (longest.step(sheriff, 0) == ScriptRunner::State::running) ++steps;
  EXPECT_LT(steps, 200) << "of 1000 actions, with the ends of scripts";
  EXPECT_EQ(longest.take_events().size(), 98302U + 2U);
}

TEST(ExplodingFiles, FiftyThousandGroups) {
  std::string text;
  for (int i = 0; i < 50000; ++i) text += "group \"" + std::to_string(i) + "\" { }\n";
  expect_cheap(text + "script \"s\" { stop group \"49999\"; }", 5.0);
}

TEST(ExplodingFiles, AFileIncludedByManyWaysIsReadOnce) {
  int reads = 0;
  const FileReader read = [&](const std::string& path) {
    ++reads;
    const int number = std::stoi(path);
    const std::string next = std::to_string(number + 1);
    const std::string both = "include \"" + next + "\"; include \"./" + next + "\";";
    return (number < 25 ? both : "") + "cmd \"" + path + "\" { exec = \"x\"; deputy = \"d\"; }";
  };
  Config config = load_config("0", read);
  EXPECT_EQ(reads, 26);
  EXPECT_THAT(all_commands(config), SizeIs(26));
  EXPECT_THAT(make_ids_unique(config), IsEmpty());
}

TEST(ExplodingFiles, IncludesAreBoundedInDepthNumberAndSize) {
  const FileReader deep = [](const std::string& path) {
    return "include \"" + std::to_string(std::stoi(path) + 1) + "\";";
  };
  EXPECT_THAT([&] { load_config("0", deep); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("32:1:1: expected at most 256 files")));
  const FileReader wide = [](const std::string& path) {
    std::string text;
    for (int i = 0; path == "all" && i < 1000; ++i)
      text += "include \"" + std::to_string(i) + "\";\n";
    return text;
  };
  EXPECT_THAT([&] { load_config("all", wide); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("all:256:1: expected at most 256")));
  const FileReader heavy = [](const std::string& path) {
    const std::string text(kMaxConfigBytes / 2, '\n');
    return path == "a" ? "include \"b\"; include \"c\";" + text : text;
  };
  EXPECT_THAT([&] { load_config("a", heavy); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("longer than 16 MB")));
}

TEST(ExplodingFiles, OnlyRegularFilesAreRead) {
  const std::string folder = testing::TempDir() + "procman_files_test";
  std::filesystem::create_directories(folder);
  const std::string pipe = folder + "/pipe";
  mkfifo(pipe.c_str(), 0600);
  const auto refusal_of = [&](const std::string& included) -> std::string {
    std::ofstream(folder + "/robot.procman") << "\n include \"" << included << "\";";
    try {
      load_config(folder + "/robot.procman");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(
      refusal_of("/dev/zero"),
      HasSubstr("robot.procman:2:2: cannot read the procman file /dev/zero: it is a device"));
  EXPECT_THAT(refusal_of("/tmp"), HasSubstr("/tmp: it is a folder, not a file"));
  EXPECT_THAT(refusal_of("pipe"), HasSubstr("it is a pipe, not a file"));
  EXPECT_THAT(refusal_of("none"), HasSubstr("No such file"));
  std::ofstream(folder + "/long") << std::string(kMaxConfigBytes + 1, ' ');
  EXPECT_THAT(refusal_of("long"), HasSubstr("longer than 16 MB"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace marco::procman
