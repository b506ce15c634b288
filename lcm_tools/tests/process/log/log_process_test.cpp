#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/select.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <random>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/support/log_command.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

using ::testing::HasSubstr;
using testing::log_program;
using testing::Outcome;
using testing::run;
using testing::run_log;
using Clock = std::chrono::steady_clock;

// A program on a terminal of its own, driven by keys.
class Terminal {
 public:
  explicit Terminal(const std::vector<std::string>& arguments) {
    pid_ = forkpty(&descriptor_, nullptr, nullptr, nullptr);
    if (pid_ == 0) {
      std::vector<char*> raw;
      for (const std::string& argument : arguments)
        raw.push_back(const_cast<char*>(argument.c_str()));
      raw.push_back(nullptr);
      execv(raw[0], raw.data());
      _exit(127);
    }
  }
  ~Terminal() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    close(descriptor_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void type(const std::string& keys) {
    EXPECT_EQ(write(descriptor_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  // Reads until `text` was shown behind what was waited for before.
  bool wait_for(const std::string& text, double seconds = 10.0) {
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    while (Clock::now() < end) {
      const std::size_t found = shown_.find(text, seen_);
      if (found != std::string::npos) {
        seen_ = found + text.size();
        return true;
      }
      fd_set set;
      FD_ZERO(&set);
      FD_SET(descriptor_, &set);
      timeval timeout = {0, 50000};
      if (select(descriptor_ + 1, &set, nullptr, nullptr, &timeout) <= 0) continue;
      char block[1024];
      const ssize_t got = read(descriptor_, block, sizeof block);
      if (got > 0) shown_.append(block, static_cast<std::size_t>(got));
    }
    return false;
  }
  int wait_for_end() {
    int status = 0;
    waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  const std::string& shown() const { return shown_; }

 private:
  pid_t pid_ = -1;
  int descriptor_ = -1;
  std::string shown_;
  std::size_t seen_ = 0;
};

// Everything that arrives on the network while `command` runs.
std::vector<files::LogEvent> listen_while(const std::string& command) {
  process::LcmBus bus("");
  std::vector<files::LogEvent> heard;
  bus.subscribe_raw(".*", [&](const process::RawMessage& message) {
    heard.push_back({0,
                     message.event_time,
                     std::string(message.channel),
                     {message.bytes.begin(), message.bytes.end()}});
  });
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  const int descriptor = fileno(pipe);
  bool running = true;
  for (auto quiet_since = Clock::now();
       running || Clock::now() - quiet_since < std::chrono::milliseconds(200);) {
    if (bus.handle_once(20)) quiet_since = Clock::now();
    if (!running) continue;
    fd_set set;
    FD_ZERO(&set);
    FD_SET(descriptor, &set);
    timeval none = {0, 0};
    char block[1024];
    if (select(descriptor + 1, &set, nullptr, nullptr, &none) > 0 &&
        read(descriptor, block, sizeof block) <= 0) {
      running = false;
      quiet_since = Clock::now();
    }
  }
  pclose(pipe);
  return heard;
}

TEST(Output, ForceNeverReplacesADevice) {
  const ScratchFolder folder;
  write_poses(folder / "log", 21);
  std::filesystem::create_symlink("/dev/null", folder / "null");
  for (const char* command : {"cut", "repair", "export --format jsonl"}) {
    const Outcome outcome =
        run_log(std::string(command) + " --force " + folder / "log" + " " + folder / "null");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  EXPECT_EQ(std::filesystem::read_symlink(folder / "null"), "/dev/null");
  std::filesystem::create_symlink("/dev/full", folder / "full");
  const Outcome full = run_log("cut " + folder / "log" + " " + folder / "full");
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_THAT(full.output, HasSubstr("No space left"));
}

TEST(Play, ASubscriberHearsEveryMessageAtTheLogsPace) {
  const ScratchFolder folder;
  write_poses(folder / "log", 21);  // 2 s
  const auto heard = listen_while(log_program() + " play --speed 2 " + folder / "log");
  ASSERT_EQ(heard.size(), 21U);
  const auto events = read_events(folder / "log");
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_EQ(heard[i].channel, events[i].channel);
    EXPECT_EQ(heard[i].bytes, events[i].bytes);
  }
  // 2 s of log at double speed; a busy machine may be late, but never early.
  const double seconds = (heard.back().event_time - heard.front().event_time).seconds();
  EXPECT_GT(seconds, 0.98);
  EXPECT_LT(seconds, 1.5);
}

TEST(Play, ChoosesRenamesAndBeginsWhereItIsTold) {
  const ScratchFolder folder;
  write_poses(folder / "log", 21);
  const auto heard = listen_while(log_program() + " play --speed 0 --from 1.0 --to 1.5 -c OTHER " +
                                  "--rename 'OTH(.*)=REPLAY_$1' " + folder / "log");
  ASSERT_EQ(heard.size(), 2U);  // 1.1 and 1.3 s
  EXPECT_EQ(heard[0].channel, "REPLAY_ER");
  EXPECT_EQ(heard[0].bytes, read_events(folder / "log")[11].bytes);
}

// A recording's orders would drive a live robot.
TEST(Play, LeavesOrdersOutUnlessAskedAndSaysSo) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    for (int i = 0; i < 4; ++i) {
      const Utime time = Utime::from_us(kStartUs + 1000 * i);
      for (const char* channel : {"TRUE_POSE", "EMERGENCY_STOP", "PM_ORDERS", "OLD"})
        writer.write(channel, pose_bytes(time.us, i), time);
    }
  }
  const auto channels_of = [&](const std::string& options) {
    std::map<std::string, int> channels;
    const std::string command = log_program() + " play --speed 0 " + (folder / "log") + " " +
                                options + " > " + (folder / "said");
    for (const auto& event : listen_while(command)) ++channels[event.channel];
    return channels;
  };
  using Channels = std::map<std::string, int>;
  EXPECT_EQ(channels_of(""), (Channels{{"TRUE_POSE", 4}, {"OLD", 4}}));
  EXPECT_THAT(read_text(folder / "said"), HasSubstr("8 events in "));
  EXPECT_THAT(read_text(folder / "said"),
              HasSubstr("left out 8 orders that a live robot would obey: 4 on EMERGENCY_STOP, 4 on "
                        "PM_ORDERS (--orders plays them)"));
  // What counts is the name under which it goes out.
  EXPECT_EQ(channels_of("--rename EMERGENCY_STOP=RECORDED --rename OLD=PMD_ORDERS"),
            (Channels{{"TRUE_POSE", 4}, {"RECORDED", 4}}));
  EXPECT_EQ(channels_of("-c EMERGENCY_STOP --orders"), (Channels{{"EMERGENCY_STOP", 4}}));
  EXPECT_EQ(read_text(folder / "said").find("left out"), std::string::npos);
}

TEST(Play, IsDrivenByKeysAtATerminal) {
  const ScratchFolder folder;
  write_poses(folder / "log", 600);  // 60 s
  Terminal terminal({log_program(), "play", "--pause", folder / "log"});
  ASSERT_TRUE(terminal.wait_for("paused ")) << terminal.shown();
  terminal.type("s");
  ASSERT_TRUE(terminal.wait_for("1 events")) << terminal.shown();
  terminal.type("s");
  ASSERT_TRUE(terminal.wait_for("2 events")) << terminal.shown();
  terminal.type("\x1b[C");  // 5 s on
  ASSERT_TRUE(terminal.wait_for("0:05.1 / 0:59.9")) << terminal.shown();
  terminal.type("\x1b[A\x1b[A");
  ASSERT_TRUE(terminal.wait_for("x4")) << terminal.shown();
  terminal.type("l ");
  ASSERT_TRUE(terminal.wait_for("playing ")) << terminal.shown();
  ASSERT_TRUE(terminal.wait_for("loop")) << terminal.shown();
  terminal.type("q");
  ASSERT_TRUE(terminal.wait_for("events in ")) << terminal.shown();
  EXPECT_EQ(terminal.wait_for_end(), 0);
}

TEST(Play, LeavesTheTerminalAsItWasWhenInterrupted) {
  const ScratchFolder folder;
  write_poses(folder / "log", 600);
  // The shell ignores Ctrl-C, the player does not; afterwards both must see the same terminal.
  Terminal terminal({"/bin/sh", "-c",
                     "trap : INT; stty -a > " + (folder / "before") + "; " + log_program() +
                         " play " + (folder / "log") + "; stty -a > " + (folder / "after") +
                         "; echo over"});
  ASSERT_TRUE(terminal.wait_for("playing ")) << terminal.shown();
  terminal.type("\x03");
  ASSERT_TRUE(terminal.wait_for("events in ")) << terminal.shown();
  ASSERT_TRUE(terminal.wait_for("over")) << terminal.shown();
  EXPECT_EQ(read_text(folder / "before"), read_text(folder / "after"));
  EXPECT_THAT(read_text(folder / "after"), HasSubstr(" icanon"));
}

TEST(Cli, MistakesAreSaidAndNothingIsWritten) {
  const ScratchFolder folder;
  write_poses(folder / "log", 5);
  write_text(folder / "text", "no log");
  const auto fails = [&](const std::string& arguments, const std::string& says) {
    const Outcome outcome = run_log(arguments);
    EXPECT_NE(outcome.exit_code, 0) << arguments;
    EXPECT_THAT(outcome.output, HasSubstr(says)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << arguments;
  };
  const std::string log = folder / "log", out = folder / "out";
  fails("info /no/such/log", "/no/such/log: cannot be read as a log");
  fails("info " + (folder / "text"), "no complete LCM event");
  fails("cut " + log + " " + log + " --force", "is the input;");
  fails("cut " + log + " " + (folder / "text"), "--force replaces it");
  fails("cut " + log + " " + out + " --from 3 --to 2", "there is nothing between");
  fails("cut " + log + " " + out + " --from soon", "not a time");
  fails("filter " + log + " " + out + " -c NOBODY", "none of its 5 events matches");
  fails("merge " + log + " " + log + " -o " + out + " --shift 1", "one for each log");
  fails("repair " + (folder / "text") + " " + out, "no complete LCM event");
  fails("export " + log + " " + out,
        "no format has this extension; choose one with --format: csv, jsonl, mcap, images");
  fails("export " + log + " " + out + " --format mcap --types /no/such", "/no/such");
  fails("play " + log + " --pause < /dev/null", "needs a terminal");
  fails("", "subcommand");
  fails("inof " + log, "did you mean 'info'?");
  fails("info --jsno " + log, "did you mean '--json'?");
}

TEST(Cli, WhatCannotBePrintedIsAFailure) {
  const ScratchFolder folder;
  write_poses(folder / "log", 50);
  const std::string log = folder / "log";
  for (const std::string& arguments :
       {"info " + log, "info --json " + log, "cut " + log + " " + (folder / "cut"),
        "merge " + log + " -o " + (folder / "merged"),
        "repair " + log + " " + (folder / "repaired"),
        "export " + log + " " + (folder / "out.jsonl"), "play --speed 0 " + log}) {
    const Outcome outcome = run("(" + log_program() + " " + arguments + " 2>&1 > /dev/full)");
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_THAT(outcome.output, HasSubstr("No space left on device")) << arguments;
  }
}

// One wrong source in a folder: it is named, the others are used.
TEST(Cli, AWrongTypeIsSaidAndTheRestIsUsed) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "types");
  write_text(folder / "types/bad_t.lcm", "struct bad_t { int32_t oops }");
  write_text(folder / "types/needs_t.lcm", "struct needs_t { unheard_of_t x; }");
  write_text(folder / "types/good_t.lcm", "package mine; struct good_t { int8_t only_here; }");
  {
    files::EventLogWriter writer(folder / "log");
    // lcm-gen's fingerprint of good_t, and a byte.
    const std::vector<uint8_t> bytes = {0xc6, 0x84, 0xac, 0x3a, 0x1c, 0x15, 0x02, 0xf1, 7};
    writer.write("GOOD", bytes, Utime::from_us(kStartUs));
  }
  const std::string types = " --types " + (folder / "types");
  for (const std::string& arguments :
       {"info " + (folder / "log"), "export " + (folder / "log") + " " + (folder / "out.jsonl"),
        "repair " + (folder / "log") + " " + (folder / "repaired")}) {
    const Outcome outcome = run_log(arguments + types);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("bad_t.lcm:1:29: expected ';'")) << arguments;
    EXPECT_THAT(outcome.output, HasSubstr("needs the type unheard_of_t")) << arguments;
  }
  EXPECT_THAT(run_log("info " + (folder / "log") + types).output, HasSubstr("mine.good_t"));
  EXPECT_THAT(read_text(folder / "out.jsonl"), HasSubstr("{\"only_here\":7}"));
}

// Events at times of any kind, no range asked for: all of them.
TEST(Cli, WithoutARangeWildTimesLoseNothing) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    for (int i = 0; i < 40; ++i) {
      writer.write("POSE", pose_bytes(kStartUs, i),
                   Utime::from_us(i % 2 == 0 ? INT64_MAX : INT64_MIN));
    }
  }
  const std::string log = folder / "log";
  EXPECT_THAT(run_log("cut " + log + " " + (folder / "cut")).output, HasSubstr("40 of 40 events"));
  EXPECT_EQ(read_text(folder / "cut"), read_text(log));
  EXPECT_THAT(run_log("filter " + log + " " + (folder / "all") + " -c POSE").output,
              HasSubstr("40 of 40 events"));
  EXPECT_THAT(run_log("export " + log + " " + (folder / "out.jsonl")).output,
              HasSubstr("40 events"));
  EXPECT_THAT(run_log("export " + log + " " + (folder / "out.mcap")).output,
              HasSubstr("40 events"));
  EXPECT_THAT(run_log("play --speed 0 " + log).output, HasSubstr("40 events"));
}

TEST(Cli, EverySubcommandWorksOnALogOnceThrough) {
  const ScratchFolder folder;
  write_poses(folder / "log", 50);
  const std::string log = folder / "log";
  const auto works = [&](const std::string& arguments, const std::string& says) {
    const Outcome outcome = run_log(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(says)) << arguments;
  };
  works("info " + log + " --types tests/types", "robot.pose2_t");
  works("info --json " + log, "\"events\": 50");
  works("cut " + log + " " + (folder / "cut") + " --from 1 --to -1", "29 of 50 events");
  works("filter " + log + " " + (folder / "filtered") + " -v -c OTHER", "25 of 50 events");
  works("merge " + (folder / "cut") + " " + (folder / "filtered") + " -o " + (folder / "merged"),
        "54 events");
  works("repair " + log + " " + (folder / "repaired"), "as they were   50");
  works("export " + log + " " + (folder / "out.jsonl"), "50 events");
  works("export " + log + " " + (folder / "out.mcap") + " --types tests/types", " topics\n");
  works("export " + log + " " + (folder / "csv") + " --format csv --types tests/types",
        "TRUE_POSE.csv");
}

TEST(Repair, OfARealLogWithTwoHundredFlippedBytes) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  const std::string path = std::string(data == nullptr ? "" : data) + "/mbot/mbot_convex.lcmlog";
  if (data == nullptr || !std::filesystem::exists(path)) {
    std::puts("SKIPPED: no mbot log in MARCO_TEST_DATA");
    return;
  }
  const ScratchFolder folder;
  std::string bytes = read_text(path);
  std::mt19937 random(2016);
  for (int i = 0; i < 200; ++i) {
    char& byte = bytes[random() % bytes.size()];
    byte = static_cast<char>(byte ^ static_cast<char>(1 + random() % 255));
  }
  write_text(folder / "bad", bytes);
  const Outcome repaired = run_log("repair " + (folder / "bad") + " " + (folder / "out"));
  std::printf("%s", repaired.output.c_str());
  EXPECT_EQ(repaired.exit_code, 0);

  const auto good = read_events(path), mended = read_events(folder / "out");
  std::map<int64_t, const files::LogEvent*> by_number;
  for (const auto& event : good) by_number[event.number] = &event;
  int same_head = 0, same = 0;
  for (const auto& event : mended) {
    const auto found = by_number.find(event.number);
    if (found == by_number.end() || found->second->channel != event.channel) continue;
    // A damaged low byte of a time cannot be seen: it stays within the two seconds that could be.
    if (std::abs(found->second->event_time.us - event.event_time.us) > 2'000'000) continue;
    ++same_head;
    same += found->second->bytes == event.bytes ? 1 : 0;
  }
  lcm::LogFile theirs(folder / "bad", "r");
  int liblcm = 0;
  while (theirs.readNextEvent() != nullptr) ++liblcm;
  std::printf(
      "of %zu events: %zu written, %d with their number, channel and time, %d of these with "
      "every byte; liblcm reads %d of the damaged log\n",
      good.size(), mended.size(), same_head, same, liblcm);
  // 200 bytes touch at most 200 events; of these, what lies in headers must be mended.
  EXPECT_GE(same, static_cast<int>(good.size()) - 200);
  EXPECT_GE(same_head, static_cast<int>(good.size()) - 3);
  EXPECT_LT(liblcm, same_head);
}

TEST(Mcap, IsReadByTheFormatsOwnLibrary) {
  const ScratchFolder folder;
  write_poses(folder / "log", 9000);
  const std::string check =
      "node " + std::filesystem::absolute("tests/process/log/mcap_check.cjs").string() + " ";
  if (run("node --version").exit_code != 0 || run(check + "/dev/null").exit_code == 77) {
    std::puts("SKIPPED: no node, or no @mcap/core where NODE_PATH says");
    return;
  }
  ASSERT_EQ(
      run_log("export " + (folder / "log") + " " + (folder / "out.mcap") + " --types tests/types")
          .exit_code,
      0);
  const Outcome outcome = run(check + (folder / "out.mcap"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("\"TRUE_POSE\":4500"));
  EXPECT_THAT(outcome.output, HasSubstr("\"whole\":true"));
}

}  // namespace
}  // namespace marco::logs
