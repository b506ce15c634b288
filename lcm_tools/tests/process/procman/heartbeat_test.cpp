#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/tests/process/procman/procman_bench.hpp"

namespace marco::procman {
namespace {

using testing::HasSubstr;

/// Field `number` of /proc/PID/stat: 3 the state, 4 the parent.
std::string stat_field(pid_t pid, int number) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  std::getline(file, line);
  std::istringstream fields(line.substr(std::min(line.size(), line.rfind(')') + 2)));
  std::string field;
  for (int i = 2; i < number; ++i) fields >> field;
  return field;
}

class HeartbeatTest : public ProcmanBench {
 protected:
  /// An exec string of heartbeat_command.cpp, which stands beside this test.
  static std::string command(const std::string& what) {
    return std::filesystem::read_symlink("/proc/self/exe").parent_path().string() +
           "/procman_heartbeat_command " + what;
  }

  bool hangs(const std::string& id) const { return stat_field(status(id).pid, 3) == "T"; }
  bool is_reported(const std::string& id) {
    return output_[id].find("killed: its heartbeat was silent for 3 s") != std::string::npos;
  }
  /// The guardian's process id; 0 before it wrote it and when it is done.
  pid_t guardian() const {
    std::ifstream file(folder_ + "/guardian");
    pid_t pid = 0;
    file >> pid;
    return file ? pid : 0;
  }
  void order_guarded() {
    const std::string exec = command("guardian " + folder_ + "/guardian beat 0.5 hang");
    order({"guarded", exec, "", true, SIGINT, 0.3}, 1);
  }
};

// What nobody promised is not watched, and nobody else may promise it.
TEST_F(HeartbeatTest, OnlyAPromisedBeatThatFallsSilentIsKilled) {
  start_deputy();
  order({"silent", command("beat 0.5 hang"), "", true, SIGINT, 0.3}, 1);
  order({"child", "bash -c '" + command("beat 0.5 hang") + "; echo not reached'"}, 1);
  // A stopped process ends by SIGKILL only, with the test.
  order({"never", command("hang"), "", false, SIGINT, 0.3}, 1);
  order({"withdrawn", command("beat 0.2 stopping hang"), "", false, SIGINT, 0.3}, 1);
  order({"alive", command("beat 1000")}, 1);
  ASSERT_TRUE(wait_until([&] { return hangs("silent") && hangs("never") && hangs("withdrawn"); }));
  const int64_t silent_us = monotonic_us();
  const pid_t first = status("silent").pid;
  const Descriptor stranger(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  for (const auto& file :
       std::filesystem::directory_iterator(folder_ + "/run/marco-procman/bench")) {
    const auto address = socket_address(file.path());
    if (file.path().extension() != ".beat") continue;
    sendto(stranger.get(), "WATCHDOG=1\nOUTLIVES=1", 21, MSG_DONTWAIT,
           reinterpret_cast<const sockaddr*>(&*address), sizeof *address);
  }
  ASSERT_TRUE(wait_until([&] { return !is_alive(first); }));
  const double after_s = static_cast<double>(monotonic_us() - silent_us) * 1e-6;
  std::printf("killed after %.2f s\n", after_s);
  EXPECT_GT(after_s, 2.8);
  EXPECT_LT(after_s, 15.0);
  ASSERT_TRUE(wait_until([&] { return runs("silent", 1) && status("silent").pid != first; }));
  EXPECT_TRUE(wait_until([&] { return is_reported("silent"); }));
  EXPECT_TRUE(wait_until([&] { return has_ended("child", 1) && is_reported("child"); }));
  EXPECT_EQ(status("child").exit_code, SIGKILL);
  EXPECT_THAT(programs_output(), HasSubstr("silent: killed: its heartbeat was silent for 3 s"));
  wait_until([] { return false; }, 1.5);
  for (const std::string id : {"never", "withdrawn", "alive"}) EXPECT_TRUE(runs(id, 1)) << id;
}

// As a program expects that asks systemd's library. A service that the deputy runs in is not meant.
TEST_F(HeartbeatTest, TheEnvironmentNamesTheKeeper) {
  setenv("NOTIFY_SOCKET", "/of/a/service", 1);
  setenv("WATCHDOG_PID", "1", 1);
  start_deputy();
  unsetenv("NOTIFY_SOCKET");
  unsetenv("WATCHDOG_PID");
  order({"env", "bash -c 'echo $NOTIFY_SOCKET $WATCHDOG_USEC; ((WATCHDOG_PID == $$)) && echo me'"},
        1);
  ASSERT_TRUE(wait_until([&] { return has_ended("env", 1); }));
  EXPECT_THAT(file_of("env"), HasSubstr(folder_ + "/run/marco-procman/bench/"));
  EXPECT_THAT(file_of("env"), HasSubstr(".beat 3000000\nme\n"));
}

TEST_F(HeartbeatTest, TheKeeperWatchesWithoutADeputy) {
  start_deputy();
  order({"silent", command("beat 0.5 hang"), "", true, SIGINT, 0.3}, 1);
  ASSERT_TRUE(wait_until([&] { return hangs("silent"); }));
  const pid_t first = status("silent").pid;
  deputy_->signal(SIGKILL);
  EXPECT_EQ(deputy_->wait_s(5.0), 128 + SIGKILL);
  EXPECT_TRUE(wait_until([&] { return !is_alive(first); }));
  start_deputy();
  EXPECT_TRUE(wait_until([&] { return is_reported("silent"); }));
  EXPECT_TRUE(wait_until([&] { return runs("silent", 1) && status("silent").pid != first; }));
}

// As a container that is frozen, and thawed process by process.
TEST_F(HeartbeatTest, WhatTheKeeperSleptOverIsNotCounted) {
  start_deputy();
  order({"beats", command("beat 1000")}, 1);
  ASSERT_TRUE(wait_until([&] { return runs("beats", 1); }));
  wait_until([] { return false; }, 0.5);
  const pid_t pid = status("beats").pid;
  const pid_t keeper = std::stoi(stat_field(pid, 4));
  kill(keeper, SIGSTOP);
  kill(pid, SIGSTOP);
  wait_until([] { return false; }, 4.0);
  kill(keeper, SIGCONT);
  wait_until([] { return false; }, 0.5);
  kill(pid, SIGCONT);
  wait_until([] { return false; }, 0.5);
  EXPECT_TRUE(is_alive(pid));
}

TEST_F(HeartbeatTest, AGuardianOutlivesItsCommandAndDelaysNothing) {
  start_deputy();
  order_guarded();
  ASSERT_TRUE(wait_until([&] { return hangs("guarded") && guardian() > 0; }));
  const pid_t first = status("guarded").pid;
  const pid_t guard = guardian();
  ASSERT_TRUE(wait_until([&] { return runs("guarded", 1) && status("guarded").pid != first; }));
  EXPECT_TRUE(is_alive(guard)) << "with the next run at work";
  // The same for a stop, by the deputy's end.
  ASSERT_TRUE(wait_until([&] { return guardian() > 0 && guardian() != guard; }));
  const pid_t second = guardian();
  const pid_t next = status("guarded").pid;
  ASSERT_TRUE(wait_until([&] { return hangs("guarded"); }));
  deputy_->signal(SIGTERM);
  EXPECT_EQ(deputy_->wait_s(10.0), 0);
  EXPECT_FALSE(is_alive(next));
  EXPECT_TRUE(is_alive(second));
  EXPECT_TRUE(wait_until([&] { return !is_alive(second) && !is_alive(guard); }));
  std::ifstream file(folder_ + "/guardian");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "done\n") << "by itself";
}

}  // namespace
}  // namespace marco::procman
