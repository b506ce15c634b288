#include "lcm_tools/procman/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "lcm_tools/procman/exec_line.hpp"

namespace marco::procman {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const char* const kWholeGrammar = R"(
# A comment; { } = in it mean nothing.
cmd "solo" { exec = "echo \"a b\"\t\\n"; host = "base"; } # the other dialect
group "drivers" {
  cmd "lidar" {
    exec = "marco-lidar --port /dev/ttyUSB0";
    deputy = "localhost";
    auto_respawn = "Yes";
    stop_signal = 15;
    stop_time_allowed = 3;
    environment = "A=1 B='x y'";
    working_directory = "$HOME/my robot";
  }
  group "cameras" { cmd "left" { exec = "cam"; deputy = "localhost"; group = "drivers/cameras"; } }
}
group "drivers" { cmd "imu" { exec = "imu"; deputy = "localhost"; } }
script "go/all" {
  start everything;
  stop group "drivers/cameras" wait "stopped";
  restart cmd "lidar" wait publishing "LIDAR" timeout ms 5000 then abort;
  start cmd "imu" wait "running" timeout ms 10 then continue;
  wait ms 250;
  wait cmd "imu" status "running";
  wait group "drivers" publishing "IMU" timeout ms 7 then continue;
  run_script "end";
}
script "end" { stop everything; }
)";

std::string error_of(const std::string& text) {
  try {
    parse_config(text, "robot.procman");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Config, ReadsTheWholeGrammarOfBothDialects) {
  const Config config = parse_config(kWholeGrammar, "robot.procman");
  const std::vector<PlacedCommand> commands = all_commands(config);
  ASSERT_EQ(commands.size(), 4U);
  EXPECT_EQ(commands[0].command.exec, "echo \"a b\"\t\\n");
  EXPECT_EQ(commands[0].command.deputy, "base");
  EXPECT_EQ(commands[0].command.stop_signal, 2);
  EXPECT_EQ(commands[0].command.stop_time_allowed_s, 7);
  const CommandConfig& lidar = commands[1].command;
  EXPECT_EQ(lidar.id, "lidar");
  EXPECT_TRUE(lidar.auto_respawn);
  EXPECT_EQ(lidar.stop_signal, 15);
  EXPECT_EQ(lidar.stop_time_allowed_s, 3);
  EXPECT_EQ(lidar.wire_exec(),
            "A=1 B='x y' env -C \"$HOME/my robot\" marco-lidar --port /dev/ttyUSB0");
  EXPECT_EQ(commands[2].command.id, "imu") << "a group opened again is the same group";
  EXPECT_EQ(commands[3].group, "drivers/cameras");
  ASSERT_EQ(config.scripts.size(), 2U);
  const std::vector<ScriptAction>& actions = config.scripts[0].actions;
  ASSERT_EQ(actions.size(), 8U);
  EXPECT_EQ(actions[0].target.kind, TargetKind::everything);
  EXPECT_EQ(actions[1].wait->what, WaitFor::stopped);
  EXPECT_EQ(actions[2].wait->channel, "LIDAR");
  EXPECT_EQ(actions[2].wait->timeout_ms, 5000);
  EXPECT_FALSE(actions[2].wait->continue_after_timeout);
  EXPECT_TRUE(actions[3].wait->continue_after_timeout);
  EXPECT_EQ(actions[4].wait_ms, 250);
  EXPECT_EQ(actions[7].script, "end");
  EXPECT_THAT(find_mistakes(config), IsEmpty());
  EXPECT_THAT(find_script_mistakes(config), IsEmpty());
}

TEST(Config, ErrorsNameFileLineColumnAndWhatWasExpected) {
  EXPECT_EQ(error_of("cmd \"a\" {\n  exec \"x\";\n}"),
            "robot.procman:2:8: expected '=', got string \"x\"");
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"x\"; nice = 3; }"),
              HasSubstr("robot.procman:1:23: expected exec, deputy, host"));
  EXPECT_THAT(error_of("cmd \"a\" { deputy = \"x\"; }"), HasSubstr("expected an attribute 'exec'"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"\"; }"), HasSubstr("1:18: expected the command line"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"x\"; stop_signal = 0; }"),
              HasSubstr("from 1 to 64), got integer 0"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"x\"; stop_signal = \"2\"; }"),
              HasSubstr("the number of a signal"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"x\"; stop_time_allowed = 99999999999; }"),
              HasSubstr("seconds"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = true; }"), HasSubstr("in double quotes, got 'true'"));
  EXPECT_THAT(error_of("cmd \"a/b\" { exec = \"x\"; }"), HasSubstr("without '/'"));
  EXPECT_THAT(error_of("group \" \" { }"), HasSubstr("blank"));
  EXPECT_THAT(error_of("group \"\" { }"), HasSubstr("not empty"));
  EXPECT_THAT(error_of("group \"a\" { script \"s\" { } }"),
              HasSubstr("1:13: expected 'cmd', 'group' or '}', got 'script'"));
  EXPECT_THAT(error_of("group \"a\" {"), HasSubstr("got the end of the file"));
  EXPECT_THAT(error_of("cmd \"a\nb\" { }"), HasSubstr("1:5: this string does not end"));
  EXPECT_THAT(error_of("cmd 'a' { }"), HasSubstr("1:5: expected a name"));
  EXPECT_THAT(error_of("script \"s\" { wait everything status \"running\"; }"),
              HasSubstr("expected 'ms', 'cmd' or 'group', got 'everything'"));
  EXPECT_THAT(error_of("script \"s\" { start cmd \"a\" wait running; }"),
              HasSubstr("expected \"running\" or \"stopped\", got 'running'"));
  EXPECT_THAT(error_of("script \"s\" { start cmd \"a\" }"), HasSubstr("expected 'wait' or ';'"));
  EXPECT_THAT(error_of("script \"s\" { wait cmd \"a\" status \"running\" timeout ms 5; }"),
              HasSubstr("expected 'then'"));
  EXPECT_THAT(error_of("script \"s\" { } script \"s\" { }"), HasSubstr("expected another name"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"x\"; environment = \"nothing\"; }"),
              HasSubstr("NAME=value"));
  EXPECT_THAT(error_of("cmd \"a\" { exec = \"x\"; group = \"g\"; }"), HasSubstr("'group'"));
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "group \"g\" { ";
  EXPECT_THAT(error_of(deep), HasSubstr("nested"));
}

TEST(Config, TheLastOfTwoEqualAttributesCounts) {
  const Config config = parse_config("cmd \"a\" { exec = \"x\"; exec = \"y\"; }", "f");
  EXPECT_EQ(config.root.commands[0].exec, "y");
}

TEST(Config, FindsWhatParsesButCannotRun) {
  const Config config = parse_config(R"(
cmd { exec = "x"; deputy = "d"; }
cmd "a" { exec = "x"; }
group "g" { cmd "a" { exec = "x"; deputy = "d"; } }
script "s" { start cmd "b"; stop group "g/h"; run_script "none"; run_script "t"; }
script "t" { run_script "u"; }
script "u" { run_script "s"; }
)",
                                     "f");
  EXPECT_THAT(find_mistakes(config), ElementsAre(HasSubstr("f:2:1: expected an id"),
                                                 HasSubstr("f:3:1: expected an attribute"),
                                                 HasSubstr("f:4:13: expected another id")));
  const auto scripts = find_script_mistakes(config);
  EXPECT_THAT(
      scripts.at("s"),
      ElementsAre(HasSubstr("f:5:14: expected a command"), HasSubstr("f:5:29: expected a group"),
                  HasSubstr("f:5:47: expected a script of"), HasSubstr("forms a cycle")));
  EXPECT_THAT(scripts.at("t"), ElementsAre(HasSubstr("forms a cycle")));
  EXPECT_THAT(scripts.at("u"), ElementsAre(HasSubstr("forms a cycle")));
}

TEST(Config, AGroupMeansItsSubgroupsAndSlashesDoNotMatter) {
  EXPECT_TRUE(group_is_within("drivers/cameras", "drivers"));
  EXPECT_TRUE(group_is_within("drivers", "/drivers//"));
  EXPECT_FALSE(group_is_within("drivers2", "drivers"));
  EXPECT_FALSE(group_is_within("drivers", "drivers/cameras"));
}

TEST(Config, IncludesAreRelativeToTheirFileAndMayNotGoRound) {
  std::map<std::string, std::string> files = {
      {"robots/a.procman",
       "include \"../common/b.procman\";\n"
       "group \"g\" { cmd \"one\" { exec = \"1\"; deputy = \"d\"; } }"},
      {"common/b.procman", "group \"g\" { cmd \"two\" { exec = \"2\"; deputy = \"d\"; } }"}};
  const FileReader read = [&](const std::string& path) {
    if (!files.contains(path)) throw std::runtime_error("cannot read " + path);
    return files[path];
  };
  const Config config = load_config("robots/a.procman", read);
  ASSERT_EQ(config.root.groups.size(), 1U);
  EXPECT_EQ(config.root.groups[0].commands.size(), 2U);
  files["common/b.procman"] = "\n include \"../robots/a.procman\";";
  EXPECT_THAT([&] { load_config("robots/a.procman", read); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("common/b.procman:2:2: ")));
  files["common/b.procman"] = "include \"none\";";
  EXPECT_THAT([&] { load_config("robots/a.procman", read); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("cannot read common/none")));
}

/// A random config: every construct of the grammar, with texts that need every escape.
class RandomConfig {
 public:
  explicit RandomConfig(unsigned seed) : random_(seed) {}

  Config config() {
    Config config;
    for (int n = below(3); n > 0; --n) config.includes.push_back({name(), {}});
    config.root = group("", 0);
    const int scripts = below(4);
    for (int n = 0; n < scripts; ++n) {
      config.scripts.push_back({"s/" + std::to_string(n) + name(), {}, {}});
      for (int k = below(6); k > 0; --k) config.scripts.back().actions.push_back(action());
    }
    return config;
  }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

  std::string name() {
    const std::string alphabet = "abZ_0 \\\"'#;{}=\n\r\t\xc3\x28";
    std::string text = "x";
    for (int n = below(8); n > 0; --n) text += alphabet[static_cast<std::size_t>(below(18))];
    return text;
  }

  CommandConfig command() {
    CommandConfig command;
    command.id = below(8) == 0 ? "" : name();
    command.exec = name();
    command.deputy = below(8) == 0 ? "" : name();
    command.auto_respawn = below(2) == 0;
    command.stop_signal = 1 + below(64);
    command.stop_time_allowed_s = 1 + below(100);
    if (below(2) == 0) command.environment = "A=" + quote_word(name());
    if (below(2) == 0) command.working_directory = name();
    return command;
  }

  GroupConfig group(const std::string& group_name, int depth) {
    GroupConfig group{group_name, {}, {}};
    for (int n = below(3); n > 0; --n) group.commands.push_back(command());
    if (depth == 3) return group;
    const int groups = below(3);
    for (int n = 0; n < groups; ++n) {
      group.groups.push_back(this->group(std::to_string(n) + name(), depth + 1));
    }
    return group;
  }

  ScriptAction action() {
    ScriptAction action;
    action.kind = static_cast<ActionKind>(below(6));
    if (action.kind == ActionKind::run_script) action.script = name();
    if (action.kind == ActionKind::wait_ms) action.wait_ms = below(100000);
    if (action.kind == ActionKind::run_script || action.kind == ActionKind::wait_ms) return action;
    const bool is_wait = action.kind == ActionKind::wait_for;
    action.target.kind = static_cast<TargetKind>(is_wait ? 1 + below(2) : below(3));
    if (action.target.kind != TargetKind::everything) action.target.name = name();
    if (!is_wait && below(2) == 0) return action;
    action.wait.emplace();
    action.wait->what = static_cast<WaitFor>(below(3));
    if (action.wait->what == WaitFor::publishing) action.wait->channel = name();
    if (below(2) == 0) {
      action.wait->timeout_ms = below(100000);
      action.wait->continue_after_timeout = below(2) == 0;
    }
    return action;
  }

  std::mt19937 random_;
};

TEST(Config, PrintingAndParsingAgainGivesTheSame) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const Config config = RandomConfig(seed).config();
    const std::string text = print_config(config);
    ASSERT_EQ(parse_config(text, "f"), config) << "seed " << seed << ":\n" << text;
  }
}

// Cut, doubled and flipped bytes: a ConfigError or a Config, never anything else.
TEST(Config, DamagedFilesDoNoHarm) {
  std::mt19937 random(11);
  for (int round = 0; round < 2000; ++round) {
    std::string text = kWholeGrammar;
    for (int n = 0; n < 3; ++n) text[random() % text.size()] = static_cast<char>(random() % 256);
    text.resize(random() % text.size());
    try {
      Config config = parse_config(text, "f");
      make_ids_unique(config);
      find_mistakes(config);
      find_script_mistakes(config);
    } catch (const ConfigError&) {
    }
  }
}

}  // namespace
}  // namespace marco::procman
