#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "lcm_tools/procman/command_form.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const char* const kEditedRobot = R"(
cmd "logger" { exec = "logger"; deputy = "base"; }
group "drivers" {
  cmd "lidar" { exec = "lidar"; deputy = "base"; environment = "A=1"; stop_signal = 15; }
  group "cameras" { cmd "left" { exec = "cam"; deputy = "base"; } }
}
script "go" { start group "drivers"; }
)";

PlacedCommand placed(const std::string& id, const std::string& group, const std::string& exec) {
  PlacedCommand one;
  one.group = group;
  one.command.id = id;
  one.command.exec = exec;
  one.command.deputy = "base";
  return one;
}

void type(CommandForm& form, const std::string& text) {
  for (const char byte : text) form.type(byte);
}

TEST(CommandForm, GivesBackWhatItWasGiven) {
  for (const PlacedCommand& one : all_commands(parse_config(kEditedRobot, "robot"))) {
    const CommandForm form(one);
    EXPECT_EQ(form.command().command, one.command);
    EXPECT_EQ(form.command().group, one.group);
  }
}

TEST(CommandForm, IsFilledInFieldByField) {
  CommandForm form("base", "drivers");
  type(form, "gps\u00e9");
  form.erase();  // the whole character
  form.move(1);
  type(form, "marco-gps --device '/dev/ttyS1'");
  form.move(100);
  EXPECT_STREQ(form.fields()[form.chosen()].name, "working_directory");
  const PlacedCommand made = form.command();
  EXPECT_EQ(made.command.id, "gps");
  EXPECT_EQ(made.command.exec, "marco-gps --device '/dev/ttyS1'");
  EXPECT_EQ(made.group, "drivers");
  EXPECT_EQ(made.command.stop_time_allowed_s, 7);
}

TEST(CommandForm, SaysWhatIsWrongWhere) {
  const auto refusal = [](const CommandForm& form) -> std::string {
    try {
      form.command();
      return "";
    } catch (const ConfigError& error) {
      return error.what();
    }
  };
  CommandForm form("base", "");
  EXPECT_THAT(refusal(form), HasSubstr("id: expected a name"));
  type(form, "a/b");
  EXPECT_THAT(refusal(form), HasSubstr("id: expected a name without '/'"));
  CommandForm edit(placed("logger", "", "logger"));
  edit.move(-5);
  EXPECT_STREQ(edit.fields()[edit.chosen()].name, "exec") << "an id stays";
  edit.move(4);
  type(edit, "9x");
  EXPECT_THAT(refusal(edit), HasSubstr("stop_signal: expected a whole number from 1 to 64"));
}

TEST(ConfigEditing, PutsRemovesAndPrintsWhatItBecame) {
  Config config = parse_config(kEditedRobot, "robot");
  put_command(config, placed("gps", "drivers/positions", "gps"));
  put_command(config, placed("logger", "drivers", "logger -v"));  // moves into a group
  put_command(config, placed("lidar", "drivers", "lidar2"));      // stays in its place
  EXPECT_TRUE(remove_command(config, "left"));
  EXPECT_FALSE(remove_command(config, "left"));
  std::vector<std::string> seen;
  for (const PlacedCommand& one : all_commands(config)) {
    seen.push_back(one.group + ":" + one.command.id + ":" + one.command.exec);
  }
  EXPECT_THAT(seen, ElementsAre("drivers:lidar:lidar2", "drivers:logger:logger -v",
                                "drivers/positions:gps:gps"));
  EXPECT_EQ(parse_config(print_config(config), "again"), config);
}

DeputyInfo info_of(const std::vector<CommandStatus>& commands) {
  return {1'000'000, "base", {}, commands};
}
CommandStatus report(const std::string& id, int32_t pid, int32_t runid) {
  CommandStatus status;
  status.spec.id = id;
  status.pid = pid;
  status.actual_runid = runid;
  return status;
}
std::vector<std::string> ordered(SheriffState& sheriff, int64_t now_us) {
  std::vector<std::string> ids;
  for (const Orders& orders : sheriff.take_due_orders(now_us, now_us)) {
    for (const CommandOrder& order : orders.commands) {
      ids.push_back(order.spec.id + (order.force_quit ? " stop" : ""));
    }
  }
  return ids;
}

TEST(SheriffEditing, ARunningCommandIsStoppedBeforeItIsLeftOut) {
  SheriffState sheriff("me");
  sheriff.load(parse_config(kEditedRobot, "robot"));
  sheriff.on_info(info_of({report("lidar", 7, 1)}), 1, 1);
  ordered(sheriff, 2);
  sheriff.remove("lidar");
  EXPECT_EQ(sheriff.commands().at("lidar").status(), Status::stopping);
  EXPECT_THAT(ordered(sheriff, 3), ElementsAre("left stop", "lidar stop", "logger stop"));
  sheriff.on_info(info_of({report("lidar", 0, 1)}), 4, 4);
  EXPECT_FALSE(sheriff.commands().contains("lidar"));
  EXPECT_THAT(ordered(sheriff, 5), ElementsAre("left stop", "logger stop"));
  // A deputy that still lists it does not bring it back; one in which it runs again does.
  sheriff.on_info(info_of({report("lidar", 0, 1)}), 6, 6);
  EXPECT_FALSE(sheriff.commands().contains("lidar"));
  sheriff.on_info(info_of({report("lidar", 9, 2)}), 7, 7);
  EXPECT_TRUE(sheriff.commands().contains("lidar"));
  EXPECT_THROW(sheriff.remove("radar"), std::invalid_argument);
}

TEST(SheriffEditing, APutCommandIsOrderedAtOnceAndStartsNothing) {
  SheriffState sheriff("me");
  sheriff.on_info(info_of({report("lidar", 7, 1)}), 1, 1);
  ordered(sheriff, 2);
  sheriff.put(placed("gps", "drivers", "gps"));
  sheriff.put(placed("lidar", "drivers", "lidar --fast"));
  const auto orders = sheriff.take_due_orders(3, 3);
  ASSERT_EQ(orders.size(), 1U);
  ASSERT_EQ(orders[0].commands.size(), 2U);
  EXPECT_EQ(orders[0].commands[0].desired_runid, 0);
  EXPECT_EQ(orders[0].commands[1].spec.exec, "lidar --fast");
  EXPECT_EQ(orders[0].commands[1].desired_runid, 1) << "what runs goes on";
  EXPECT_FALSE(orders[0].commands[1].force_quit);
  PlacedCommand elsewhere = placed("lidar", "drivers", "lidar");
  elsewhere.command.deputy = "arm";
  sheriff.put(elsewhere);
  EXPECT_THAT(ordered(sheriff, 4), ElementsAre("gps"));
}

}  // namespace
}  // namespace marco::procman
