#include "lcm_tools/procman/script_runner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/tests/unit/procman/sheriff_world.hpp"

namespace marco::procman {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using State = ScriptRunner::State;

TEST(ScriptRunner, RunsEveryActionInItsTurn) {
  SheriffWorld world;
  ScriptRunner script(world.config, "go");
  const auto step = [&](int64_t pass_us) {
    world.pass(pass_us);
    return script.step(world.sheriff, world.now_us);
  };
  EXPECT_THAT(script.channels(), ElementsAre("LOG"));
  EXPECT_EQ(step(0), State::running);
  EXPECT_EQ(world.status("lidar"), Status::starting);
  EXPECT_EQ(script.waiting_for(), "group \"drivers\" to run");
  step(1000);  // running; then a pause until 0.1 s after the action began
  EXPECT_EQ(script.next_due_us(), 100 * kSecondUs + 100'000);
  step(100'000);  // wait ms 500
  EXPECT_EQ(world.status("logger"), Status::stopped_ok);
  EXPECT_EQ(script.next_due_us(), world.now_us + 500'000);
  step(500'000);  // run_script: logger is started
  EXPECT_EQ(world.status("logger"), Status::starting);
  step(1000);
  EXPECT_EQ(script.waiting_for(), "cmd \"logger\" to publish LOG");
  script.on_message("LOG", world.now_us);
  step(1000);
  step(100'000);  // stop everything
  EXPECT_EQ(world.status("left"), Status::stopping);
  step(1000);
  EXPECT_EQ(step(100'000), State::finished);
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  EXPECT_THAT(script.take_events(), Contains("run_script \"inner\""));
}

TEST(ScriptRunner, AMessageFromBeforeTheActionDoesNotCount) {
  SheriffWorld world;
  ScriptRunner script(world.config, "inner");
  script.on_message("LOG", world.now_us - 1);
  script.step(world.sheriff, world.now_us);
  world.pass(1000);
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::running);
  EXPECT_NE(script.waiting_for(), "");
}

TEST(ScriptRunner, ATimeoutAbortsOrContinuesAsTheScriptSays) {
  SheriffWorld world;
  ScriptRunner strict(world.config, "inner");
  strict.step(world.sheriff, world.now_us);
  world.pass(1000);
  strict.step(world.sheriff, world.now_us);
  EXPECT_EQ(strict.next_due_us(), 102 * kSecondUs);
  world.pass(2 * kSecondUs);
  EXPECT_EQ(strict.step(world.sheriff, world.now_us), State::aborted);
  EXPECT_THAT(strict.take_events(),
              Contains(HasSubstr(
                  "timed out after 2000 ms waiting for cmd \"logger\" to publish LOG (robot")));
  ScriptRunner lenient(world.config, "lenient");
  lenient.step(world.sheriff, world.now_us);
  world.pass(2 * kSecondUs);
  EXPECT_EQ(lenient.step(world.sheriff, world.now_us), State::finished);
  EXPECT_EQ(world.status("logger"), Status::stopping);
}

TEST(ScriptRunner, WhatHasEndedCannotPublish) {
  SheriffWorld world;
  ScriptRunner script(world.config, "inner");
  script.step(world.sheriff, world.now_us);
  world.pass(1000);
  world.deputy.on_ended("logger", 1 << 8, world.now_us);
  world.exchange();
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::aborted);
}

// As a guest of the sheriff's does. What was to stop did.
TEST(ScriptRunner, WhatSomebodyStartsAgainHasStopped) {
  SheriffWorld world;
  world.sheriff.start("lidar");
  world.exchange();
  const Config config = parse_config(
      "script \"s\" { stop cmd \"lidar\" wait \"stopped\"; wait cmd \"lidar\" status \"stopped\"; "
      "}",
      "f");
  world.config.scripts = config.scripts;
  ScriptRunner script(world.config, "s");
  for (int wait = 0; wait < 2; ++wait) {
    script.step(world.sheriff, world.now_us);
    world.sheriff.restart("lidar");
    EXPECT_EQ(script.step(world.sheriff, world.now_us), State::running) << "not yet";
    world.pass(kSecondUs);
    EXPECT_EQ(world.status("lidar"), Status::running);
    script.step(world.sheriff, world.now_us);
    world.pass(kSecondUs);
  }
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::finished);
}

TEST(ScriptRunner, WhatWasStoppedOnOrderCannotPublish) {
  SheriffWorld world;
  for (PlacedCommand placed : all_commands(world.config)) {
    placed.command.auto_respawn = true;
    world.sheriff.put(placed);
  }
  ScriptRunner script(world.config, "inner");
  script.step(world.sheriff, world.now_us);
  world.pass(1000);
  world.deputy.on_ended("logger", 1 << 8, world.now_us);
  world.exchange();
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::running) << "it respawns";
  world.sheriff.stop("logger");
  world.pass(1000);
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::aborted);
}

TEST(ScriptRunner, TellsForWhomItWaitsSinceWhenAndThatItWasInVain) {
  SheriffWorld world;
  ScriptRunner script(world.config, "inner");
  EXPECT_EQ(script.waiting_since_us(), std::nullopt);
  script.step(world.sheriff, world.now_us);
  EXPECT_EQ(script.waiting_since_us(), world.now_us);
  EXPECT_THAT(script.waited_for(), ElementsAre("logger"));
  EXPECT_FALSE(script.take_wait_failed());
  world.pass(2 * kSecondUs);
  script.step(world.sheriff, world.now_us);
  EXPECT_TRUE(script.take_wait_failed());
  EXPECT_FALSE(script.take_wait_failed());
}

// Else no key and no signal would be heard until a long script without waits is over.
TEST(ScriptRunner, ALongScriptLetsOthersInBetween) {
  std::string text = "script \"s\" {";
  for (int i = 0; i < 1500; ++i) text += " stop everything;";
  const Config config = parse_config(text + " }", "f");
  SheriffState sheriff("me");
  ScriptRunner script(config, "s");
  EXPECT_EQ(script.step(sheriff, 7), State::running);
  EXPECT_EQ(script.next_due_us(), 7);
  EXPECT_EQ(script.step(sheriff, 8), State::finished);
}

TEST(ScriptRunner, AnUnknownNameIsRefused) {
  SheriffWorld world;
  EXPECT_THROW(ScriptRunner(world.config, "none"), std::invalid_argument);
}

}  // namespace
}  // namespace marco::procman
