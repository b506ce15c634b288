// marco-guardian itself, on a pseudo-terminal whose other end is the test. The test is the driver,
// or a child of it is, which hangs and dies.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "drivers/process/guardian_link.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::drivers {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using Bytes = std::vector<uint8_t>;
using ::testing::HasSubstr;

const Bytes kStop{'s', 't', 'o', 'p'};
// What takes half a second may take this long on a machine that stands still now and then.
constexpr auto kPatience = 20s;

/// A device's end of a serial line.
class Device {
 public:
  Device() : master_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    grantpt(master_.get());
    unlockpt(master_.get());
    name = ptsname(master_.get());
    set_terminal(FileHandle(open(name.c_str(), O_RDWR | O_NOCTTY)).get(), {});
  }
  std::unique_ptr<ByteStream> open_line() const { return open_stream(name, {115'200}); }
  /// What has come.
  std::string read() {
    char bytes[4096];
    std::string text;
    for (ssize_t size = 0; (size = ::read(master_.get(), bytes, sizeof bytes)) > 0;) {
      text.append(bytes, static_cast<std::size_t>(size));
    }
    return text;
  }
  /// @returns what came until `text` had, or all in vain.
  std::string read_until(const std::string& text) {
    std::string all;
    for (const auto end = steady_clock::now() + kPatience;
         steady_clock::now() < end && all.find(text) == std::string::npos;
         std::this_thread::sleep_for(2ms)) {
      all += read();
    }
    return all;
  }

  std::string name;

 private:
  FileHandle master_;
};

/// A driver at work. @returns whether this process stood still meanwhile, as on a busy machine.
bool work(GuardianLink& guardian, std::chrono::milliseconds time) {
  bool stood = false;
  auto last = steady_clock::now();
  for (const auto end = last + time; steady_clock::now() < end; std::this_thread::sleep_for(4ms)) {
    guardian.take_hang_s();
    guardian.beat(kStop);
    const auto now = steady_clock::now();
    stood = stood || now - std::exchange(last, now) > 400ms;
  }
  return stood;
}

/// The guardians of this test program, by the name that they were given.
std::vector<pid_t> guardians(const std::string& name) {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "cmdline");
    const std::string line{std::istreambuf_iterator<char>(file), {}};
    if (line.find("marco-guardian") != std::string::npos && line.find(name) != std::string::npos) {
      found.push_back(std::atoi(entry.path().filename().c_str()));
    }
  }
  return found;
}

class GuardianProcess : public ::testing::Test {
 protected:
  ~GuardianProcess() override {
    for (const pid_t pid : guardians(name_)) kill(pid, SIGKILL);
  }
  std::vector<std::string> arguments() const { return {"--driver", name_}; }
  bool are_gone() const {
    for (const auto end = steady_clock::now() + kPatience; steady_clock::now() < end;
         std::this_thread::sleep_for(10ms)) {
      if (guardians(name_).empty()) return true;
    }
    return false;
  }
  /// A driver in a process of its own. @param ends  its last act
  pid_t start_driver(const std::function<void(GuardianLink&, ByteStream&)>& drives) const {
    const pid_t pid = fork();
    if (pid != 0) return pid;
    GuardianLink guardian(arguments());
    guardian.start();
    const auto line = device_.open_line();
    GuardedStream guarded(*line, guardian);
    drives(guardian, guarded);
    _exit(0);
  }

  const std::string name_ = ::testing::UnitTest::GetInstance()->current_test_info()->name() +
                            std::string(" ") + std::to_string(getpid());
  Device device_;
};

TEST_F(GuardianProcess, StopsADriverThatHangsAndLetsItGoOn) {
  GuardianLink guardian(arguments());
  guardian.start();
  const auto line = device_.open_line();
  {
    GuardedStream guarded(*line, guardian);
    EXPECT_TRUE(work(guardian, 1500ms) || device_.read().empty());
    const auto since = steady_clock::now();
    EXPECT_THAT(device_.read_until("stop"), HasSubstr("stop"));
    const std::chrono::duration<double> took = steady_clock::now() - since;
    EXPECT_GT(took.count(), 0.4);
    EXPECT_LT(took.count(), 2.5);
    EXPECT_THAT(device_.read_until("stop"), HasSubstr("stop"));  // again, as long as it hangs
    // What it wanted to say before dies.
    EXPECT_TRUE(guardian.late());
    guarded.write(Bytes{'g', 'o'});
    EXPECT_THAT(device_.read(), ::testing::Not(HasSubstr("go")));
    EXPECT_GT(guardian.take_hang_s(), 0.5);
    device_.read();
    guarded.write(Bytes{'g', 'o'});
    EXPECT_THAT(device_.read_until("go"), HasSubstr("go"));
    EXPECT_TRUE(work(guardian, 1000ms) || device_.read().empty());
  }
  std::this_thread::sleep_for(700ms);  // the line is not shared any more
  EXPECT_EQ(device_.read(), "");
}

TEST_F(GuardianProcess, StopsForADriverThatWasKilledAndEnds) {
  const pid_t driver = start_driver([](GuardianLink& guardian, ByteStream&) {
    work(guardian, 500ms);
    raise(SIGKILL);
  });
  waitpid(driver, nullptr, 0);
  EXPECT_THAT(device_.read_until("stopstop"), HasSubstr("stop"));
  // The next driver waits for it, rather than to be refused as a second one.
  EXPECT_THAT(testing::complaint([&] { device_.open_line(); }), HasSubstr("guardian"));
  EXPECT_THROW(device_.open_line(), StreamLost);
  EXPECT_TRUE(are_gone());
  EXPECT_NO_THROW(device_.open_line());
}

TEST_F(GuardianProcess, EndsWithADriverThatEndsInOrder) {
  const pid_t driver = start_driver([](GuardianLink& guardian, ByteStream&) {
    work(guardian, 300ms);
    guardian.let_go();
  });
  waitpid(driver, nullptr, 0);
  EXPECT_NO_THROW(device_.open_line());
  EXPECT_TRUE(are_gone());
  EXPECT_EQ(device_.read(), "");
}

// The device does not read: the buffer of the line is full, and the driver waits in write().
TEST_F(GuardianProcess, WhatWaitsInALineThatIsBlockedIsDiscarded) {
  const pid_t driver = start_driver([](GuardianLink& guardian, ByteStream& line) {
    work(guardian, 200ms);
    const Bytes orders(4096, 'g');
    try {
      while (true) line.write(orders);
    } catch (const StreamLost&) {
      std::this_thread::sleep_for(1h);
    }
  });
  std::this_thread::sleep_for(2s);
  // Some kilobytes are the device's already.
  const std::string came = device_.read_until("stop");
  EXPECT_THAT(came, HasSubstr("stop"));
  EXPECT_LE(came.find("stop"), 4200U);
  EXPECT_EQ(came.find('g', came.find("stop")), std::string::npos);
  kill(driver, SIGKILL);
  waitpid(driver, nullptr, 0);
}

// Stopped anywhere in its loop, also just before it writes, a driver sends nothing that it decided
// before. Its numbers are the milliseconds of its clock at which it decided.
TEST_F(GuardianProcess, NothingThatWasDecidedBeforeAHangIsSentAfterIt) {
  const pid_t driver = start_driver([](GuardianLink& guardian, ByteStream& line) {
    while (true) {
      guardian.take_hang_s();
      const std::string order = "g" + std::to_string(monotonic_ns() / 1'000'000) + ";";
      std::this_thread::sleep_for(1ms);
      line.write({reinterpret_cast<const uint8_t*>(order.data()), order.size()});
      guardian.beat(kStop);
    }
  });
  device_.read_until("g");
  for (int i = 0; i < 6; ++i) {
    for (const auto end = steady_clock::now() + 30ms; steady_clock::now() < end;) device_.read();
    kill(driver, SIGSTOP);
    const auto stopped_ms = monotonic_ns() / 1'000'000;
    EXPECT_THAT(device_.read_until("stop"), HasSubstr("stop"));
    kill(driver, SIGCONT);
    const std::string after = device_.read_until(";");
    const std::size_t at = after.find('g');
    ASSERT_NE(at, std::string::npos);
    EXPECT_GT(std::atoll(after.c_str() + at + 1), stopped_ms + 300);
  }
  kill(driver, SIGKILL);
  waitpid(driver, nullptr, 0);
}

TEST_F(GuardianProcess, ADriverWhoseGuardianDiesOrHangsLosesItsLine) {
  GuardianLink guardian(arguments());
  for (const int signal : {SIGKILL, SIGSTOP}) {
    guardian.start();
    const auto line = device_.open_line();
    GuardedStream guarded(*line, guardian);
    work(guardian, 100ms);
    const std::vector<pid_t> pids = guardians(name_);
    ASSERT_EQ(pids.size(), 1U);
    kill(pids[0], SIGTERM);  // which is its driver's
    work(guardian, 100ms);
    kill(pids[0], signal);
    const auto since = steady_clock::now();
    EXPECT_THROW(work(guardian, kPatience), StreamLost);
    EXPECT_LT(steady_clock::now() - since, 10s);
  }
  EXPECT_TRUE(are_gone());
}

}  // namespace
}  // namespace marco::drivers
