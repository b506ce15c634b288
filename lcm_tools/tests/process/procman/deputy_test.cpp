#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/utf8.hpp"
#include "lcm_tools/tests/process/procman/procman_bench.hpp"
#include "procman_lcm/orders_t.hpp"

namespace marco::procman {
namespace {

using testing::HasSubstr;
using testing::Not;

class DeputyTest : public ProcmanBench {};

// The public deputy loses the last lines of a command that writes much and ends (12 % of 20000).
TEST_F(DeputyTest, EveryLineIsInTheFileAndOnAnIdleNetworkInPmOutput) {
  const char* given = std::getenv("MARCO_PROCMAN_LINES");
  const std::string lines = given != nullptr ? given : "100000";
  start_deputy();
  order({"many", "bash -c 'seq 1 " + lines + "; kill -9 $$'"}, 1);
  ASSERT_TRUE(wait_until([&] { return has_ended("many", 1); }, 60.0));
  EXPECT_EQ(status("many").exit_code, SIGKILL);
  std::string expected;
  for (int i = 1; i <= std::stoi(lines); ++i) expected += std::to_string(i) + "\n";
  EXPECT_TRUE(file_of("many") == expected)
      << file_of("many").size() << " bytes of " << expected.size();
  expected += "Killed\n";
  wait_until([&] { return output_["many"].size() >= expected.size(); }, 60.0);
  EXPECT_TRUE(output_["many"] == expected)
      << output_["many"].size() << " bytes of " << expected.size();
  EXPECT_EQ(log_.lost_bytes(), 0);
}

// The public deputy kills when the next orders come: never, if the sheriff has died.
TEST_F(DeputyTest, SigkillComesOnTimeWithTheSheriffDead) {
  start_deputy();
  constexpr double kAllowed = 0.125;  // exact as a float
  std::vector<double> late_ms;
  for (int run = 1; run <= 20; ++run) {
    const CommandSpec spec = {
        "stubborn", "bash -c 'trap \"\" INT; echo on; while :; do sleep 1; done'",
        "",         false,
        SIGINT,     kAllowed};
    output_["stubborn"].clear();
    order(spec, run);
    ASSERT_TRUE(wait_until([&] {
      return runs("stubborn", run) && output_["stubborn"].find("on") != std::string::npos;
    }));
    const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, status("stubborn").pid, 0)));
    const int64_t ordered_us = monotonic_us();
    order(spec, run, true);  // and not another word
    pollfd death = {process.get(), POLLIN, 0};
    ASSERT_EQ(poll(&death, 1, 5000), 1);
    late_ms.push_back(static_cast<double>(monotonic_us() - ordered_us) * 1e-3 - kAllowed * 1e3);
    ASSERT_TRUE(wait_until([&] { return has_ended("stubborn", run); }));
  }
  std::sort(late_ms.begin(), late_ms.end());
  std::printf("SIGKILL late by [ms]: median %.2f, worst %.2f\n", late_ms[10], late_ms.back());
  EXPECT_GE(late_ms.front(), 0.0);
  EXPECT_LE(late_ms[10], 10.0);
}

TEST_F(DeputyTest, ARestartTakesOneOrder) {
  start_deputy();
  const CommandSpec spec = {"sleeper", "sleep 1000"};
  order(spec, 1);
  ASSERT_TRUE(wait_until([&] { return runs("sleeper", 1); }));
  const int32_t first = status("sleeper").pid;
  const int64_t begin_us = monotonic_us();
  order(spec, 2);
  ASSERT_TRUE(wait_until([&] { return runs("sleeper", 2); }, 5.0));
  std::printf("restarted after %.1f ms\n", static_cast<double>(monotonic_us() - begin_us) * 1e-3);
  EXPECT_NE(status("sleeper").pid, first);
}

// Between fork and exec no signal may get lost: the command would live until SIGKILL.
TEST_F(DeputyTest, AStopRightAfterTheStartIsHeeded) {
  start_deputy();
  const CommandSpec spec = {"sleeper", "sleep 1000", "", false, SIGINT, 60.0};
  for (int run = 1; run <= 10; ++run) {
    order(spec, run);
    order(spec, run, true);
    ASSERT_TRUE(wait_until([&] { return has_ended("sleeper", run); }, 30.0));
    EXPECT_EQ(status("sleeper").exit_code, SIGINT);
  }
}

TEST_F(DeputyTest, OneCharacterAndEmptyArgumentsSurvive) {
  start_deputy();
  order({"one", "printf <%s> a '' b"}, 1);
  ASSERT_TRUE(wait_until([&] { return has_ended("one", 1); }));
  EXPECT_EQ(file_of("one"), "<a><><b>");
}

TEST_F(DeputyTest, NoDescriptorLeaksIntoCommands) {
  start_deputy();
  order({"a", "sleep 1000"}, 1);
  order({"fds", "ls -1 /proc/self/fd"}, 1);
  ASSERT_TRUE(wait_until([&] { return has_ended("fds", 1); }));
  // 3 is the folder that ls itself reads.
  EXPECT_EQ(file_of("fds"), "0\n1\n2\n3\n");
}

TEST_F(DeputyTest, OutputThatIsNotUtf8HarmsNobody) {
  start_deputy();
  order({"binary", "head -c 300000 /dev/urandom"}, 1);
  order({"bytes", R"(printf 'a\\377b\\000c\\303\\244')"}, 1);
  ASSERT_TRUE(wait_until([&] { return has_ended("binary", 1) && has_ended("bytes", 1); }));
  ASSERT_TRUE(wait_until([&] { return output_["bytes"].size() >= 11; }));
  EXPECT_EQ(file_of("bytes"), std::string("a\377b\0c\303\244", 7));
  EXPECT_EQ(output_["bytes"],
            "a\xef\xbf\xbd"
            "b\xef\xbf\xbd"
            "c\xc3\xa4");
  // Every byte gives at least one; control characters of the terminal itself are off.
  wait_until([&] { return output_["binary"].size() >= 300000; });
  Utf8Cleaner cleaner;
  EXPECT_EQ(cleaner.clean(output_["binary"]), output_["binary"]) << "it was valid already";
  EXPECT_EQ(file_of("binary").size(), 300000U);
}

TEST_F(DeputyTest, ACrashLoopBacksOffAndGivesUpVisibly) {
  start_deputy({"--accept-any-orders", "--max-crashes", "4"});
  order({"crash", "sh -c 'echo x; exit 3'", "", true}, 1);
  ASSERT_TRUE(wait_until([&] { return output_["crash"].find("gave up") != std::string::npos; }));
  EXPECT_EQ(file_of("crash"), "x\nx\nx\nx\n");
  EXPECT_TRUE(has_ended("crash", 1));
  EXPECT_EQ(status("crash").exit_code, 3 << 8);
}

TEST_F(DeputyTest, NoGrandchildOutlivesItsCommand) {
  start_deputy();
  const std::string tree =
      "bash -c '(trap \"\" HUP INT; exec setsid sleep 1000) & echo $! ; (setsid sleep 1001 & echo "
      "$!) ; echo end; "
      "wait'";
  for (const std::string id : {"killed", "stopped"}) {
    order({id, tree}, 1);
    ASSERT_TRUE(wait_until([&] { return output_[id].find("end") != std::string::npos; }));
    ASSERT_TRUE(wait_until([&] { return runs(id, 1); }));
    std::istringstream text(output_[id]);
    pid_t first = 0;
    pid_t second = 0;
    text >> first >> second;
    ASSERT_TRUE(is_alive(first) && is_alive(second));
    if (id == "killed") {
      kill(status(id).pid, SIGKILL);
    } else {
      order({id, tree}, 1, true);
    }
    ASSERT_TRUE(wait_until([&] { return has_ended(id, 1); }, 3.0));
    EXPECT_FALSE(is_alive(first) || is_alive(second));
  }
}

// The tree of a command gets the stop signal, not only its first process, which may wait for it.
TEST_F(DeputyTest, AStopReachesTheChildrenToo) {
  start_deputy();
  const CommandSpec spec = {
      "family",
      "bash -c '(trap \"echo child bye; exit 0\" TERM; echo up; while :; do sleep 0.05; done) & "
      "trap \"wait; echo main bye; exit 0\" TERM; wait; wait'",
      "",
      false,
      SIGTERM,
      600.0};
  order(spec, 1);
  ASSERT_TRUE(wait_until([&] { return output_["family"].find("up") != std::string::npos; }));
  order(spec, 1, true);
  ASSERT_TRUE(wait_until([&] { return has_ended("family", 1); }));
  EXPECT_THAT(file_of("family"), HasSubstr("child bye\n"));
  EXPECT_THAT(file_of("family"), HasSubstr("main bye\n"));
}

// Who outlives the command's own process is asked to end, and killed where it will not.
TEST_F(DeputyTest, StragglersAreAskedToEndThenKilled) {
  start_deputy();
  const std::string up = folder_ + "/up";
  const std::string exit_when_up = "while [ ! -e " + up + " ]; do sleep 0.02; done; exit 3'";
  order({"polite",
         "bash -c '(trap \"echo bye; exit 0\" TERM; touch " + up +
             "; while :; do sleep 0.05; done) & " + exit_when_up,
         "", false, SIGTERM, 600.0},
        1);
  ASSERT_TRUE(wait_until([&] { return has_ended("polite", 1); }));
  EXPECT_EQ(status("polite").exit_code, 3 << 8);
  EXPECT_THAT(file_of("polite"), HasSubstr("bye\n"));
  std::filesystem::remove(up);
  order({"deaf",
         "bash -c '(trap \"\" TERM HUP; echo $BASHPID; touch " + up +
             "; while :; do sleep 0.05; done) & " + exit_when_up,
         "", false, SIGTERM, 600.0},
        1);
  ASSERT_TRUE(wait_until([&] { return has_ended("deaf", 1); }));
  const pid_t deaf = std::stoi(file_of("deaf"));
  EXPECT_FALSE(is_alive(deaf));
}

TEST_F(DeputyTest, OutputWithoutEndDoesNotFillTheDisk) {
  constexpr std::uintmax_t kLimit = 300'000;
  start_deputy({"--accept-any-orders", "--output-bytes", std::to_string(kLimit)});
  order({"flood", "bash -c 'while :; do printf 0123456789; done'"}, 1);  // and no newline
  const std::filesystem::path file = folder_ + "/state/marco-procman/bench/flood.log";
  const std::filesystem::path old = file.string() + ".1";
  std::uintmax_t most = 0;
  std::error_code none;
  const auto looked = [&](const std::filesystem::path& path) {
    const auto size = std::filesystem::file_size(path, none);
    if (none) return std::uintmax_t{0};
    most = std::max(most, size);
    return size;
  };
  // What is heard goes on over the change of files.
  ASSERT_TRUE(wait_until([&] {
    looked(file);
    return looked(old) > 0 && output_["flood"].size() > 3 * kLimit;
  }));
  EXPECT_LE(most, kLimit);
  output_["flood"].clear();
  deputy_->signal(SIGKILL);
  deputy_->wait_s(5.0);
  start_deputy({"--accept-any-orders", "--output-bytes", std::to_string(kLimit)});
  EXPECT_TRUE(wait_until([&] { return output_["flood"].size() > 2 * kLimit; }));
  order({"flood", "bash -c 'while :; do printf 0123456789; done'"}, 1, true);
  EXPECT_TRUE(wait_until([&] { return has_ended("flood", 1); }));
}

TEST_F(DeputyTest, AKilledDeputyFindsItsCommandsAgain) {
  start_deputy();
  const CommandSpec counter = {"counter",
                               "bash -c 'for i in $(seq 1000); do echo $i; sleep 0.01; done'"};
  const CommandSpec ends = {"ends", "bash -c 'sleep 0.8; exit 5'"};
  order(counter, 3);
  order(ends, 4);
  ASSERT_TRUE(wait_until([&] { return runs("counter", 3) && runs("ends", 4); }));
  const int32_t pid = status("counter").pid;
  deputy_->signal(SIGKILL);
  EXPECT_EQ(deputy_->wait_s(5.0), 128 + SIGKILL);
  wait_until([] { return false; }, 1.0);  // a network without deputy; "ends" ends
  EXPECT_TRUE(is_alive(pid));
  start_deputy();
  publish_orders();
  ASSERT_TRUE(wait_until([&] { return runs("counter", 3) && has_ended("ends", 4); }));
  EXPECT_EQ(status("counter").pid, pid) << "still the same process";
  EXPECT_EQ(status("ends").exit_code, 5 << 8) << "its end was not missed";
  const std::size_t seen = output_["counter"].size();
  ASSERT_TRUE(wait_until([&] { return output_["counter"].size() > seen + 100; }));
  std::istringstream lines(output_["counter"]);
  int expected = 0;
  for (int line = 0; lines >> line && !lines.eof();) {
    // What the killed deputy had read but not told its keeper may come twice, never not at all.
    EXPECT_LE(line, expected + 1);
    expected = line;
  }
  order(counter, 3, true);
  EXPECT_TRUE(wait_until([&] { return has_ended("counter", 3); }));
}

TEST_F(DeputyTest, WithoutTheFlagOnlyItsScriptsCommandsRunAndStay) {
  const std::string script = write_file(
      "own.procman",
      "cmd \"own\" { exec = \"sleep 1000\"; deputy = \"bench\"; environment = \"A=1\"; }\n");
  start_deputy({"--script", script});
  order({"own", "A=1 sleep 1000"}, 1);
  order({"evil", "touch " + folder_ + "/evil"}, 1);
  ASSERT_TRUE(wait_until([&] { return runs("own", 1) && has_ended("evil", 1); }));
  EXPECT_EQ(status("evil").exit_code, 126 << 8);
  ASSERT_TRUE(wait_until([&] { return output_["evil"].find("refused") != std::string::npos; }));
  EXPECT_THAT(programs_output(),
              HasSubstr("evil: refused: none of this deputy's scripts contains"));
  EXPECT_NE(access((folder_ + "/evil").c_str(), F_OK), 0);
  const int32_t pid = status("own").pid;
  // Another sheriff's order for the same id: what it would run is refused before anything is
  // stopped.
  orders_["own"] = {{"own", "touch " + folder_ + "/evil"}, 77, false};
  publish_orders("a foreign sheriff");
  ASSERT_TRUE(wait_until(
      [&] { return output_["own"].find("keeps running unchanged") != std::string::npos; }));
  EXPECT_TRUE(is_alive(pid));
  orders_.clear();
  publish_orders("a foreign sheriff");
  ASSERT_TRUE(wait_until([&] { return output_["own"].find("kept running") != std::string::npos; }));
  EXPECT_TRUE(is_alive(pid));
}

TEST_F(DeputyTest, WithTheFlagWhatIsLeftOutEnds) {
  start_deputy();
  order({"a", "sleep 1000"}, 1);
  ASSERT_TRUE(wait_until([&] { return runs("a", 1); }));
  orders_.clear();
  publish_orders();
  EXPECT_TRUE(wait_until([&] { return info_.commands.empty(); }));
}

TEST_F(DeputyTest, ASecondDeputyOfTheSameIdIsRefused) {
  start_deputy();
  auto second = start_program({"marco-procman-deputy", "-i", "bench", "--accept-any-orders"});
  EXPECT_EQ(second->wait_s(5.0), 2);
}

TEST_F(DeputyTest, SigtermEndsAllCommandsThenTheDeputy) {
  start_deputy();
  order({"polite", "bash -c 'trap \"echo bye; exit 0\" INT; while :; do sleep 0.1; done'"}, 1);
  ASSERT_TRUE(wait_until([&] { return runs("polite", 1); }));
  wait_until([] { return false; }, 0.3);
  const int32_t pid = status("polite").pid;
  deputy_->signal(SIGTERM);
  EXPECT_EQ(deputy_->wait_s(5.0), 0);
  EXPECT_FALSE(is_alive(pid));
  EXPECT_EQ(file_of("polite"), "bye\n");
}

TEST_F(DeputyTest, HostileMessagesDoNoHarm) {
  start_deputy();
  order({"sleeper", "sleep 1000"}, 1);
  ASSERT_TRUE(wait_until([&] { return runs("sleeper", 1); }));
  std::mt19937 random(9);
  procman_lcm::orders_t orders;
  orders.deputy_id = orders.sheriff_id = "";
  orders.ncmds = 0;
  std::vector<uint8_t> good(static_cast<std::size_t>(orders.getEncodedSize()));
  orders.encode(good.data(), 0, static_cast<int>(good.size()));
  for (int round = 0; round < 500; ++round) {
    std::vector<uint8_t> bad = good;  // mostly wild lengths: of strings, and of the list
    for (std::size_t i = 16; i < bad.size(); ++i) bad[i] = static_cast<uint8_t>(random());
    for (const char* channel : {"PM_ORDERS", "PM_INFO", "PM_DISCOVER"}) {
      bus_->publish_raw(channel, bad, {});
    }
  }
  const std::string long_exec(150000, 'x');
  order({"long", long_exec}, 1);
  ASSERT_TRUE(wait_until([&] { return has_ended("long", 1); }));
  EXPECT_TRUE(runs("sleeper", 1));
}

TEST_F(DeputyTest, EnvironmentFolderAndMissingProgramsAsDescribed) {
  start_deputy();
  order({"env", "A='x y' env -C \"" + folder_ + "\" bash -c 'echo $A; pwd'"}, 1);
  order({"none", "no-such-program"}, 1);
  ASSERT_TRUE(wait_until([&] { return has_ended("env", 1) && has_ended("none", 1); }));
  EXPECT_EQ(file_of("env"), "x y\n" + folder_ + "\n");
  EXPECT_EQ(status("none").exit_code, 255 << 8);
  EXPECT_THAT(file_of("none"), HasSubstr("cannot run no-such-program: No such file"));
}

TEST_F(DeputyTest, LoadIsThatOfTheWholeCommand) {
  start_deputy();
  order({"busy", "bash -c '(while :; do :; done) & wait'"}, 1);
  EXPECT_TRUE(wait_until([&] {
    return status("busy").cpu_usage > 0.1 / static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN));
  }));
  EXPECT_GT(status("busy").mem_rss_bytes, 1 << 20);
  EXPECT_GT(info_.machine.phys_mem_total_bytes, 1 << 20);
}

}  // namespace
}  // namespace marco::procman
