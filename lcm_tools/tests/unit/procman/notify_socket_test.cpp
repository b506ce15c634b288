#include "lcm_tools/procman/process/notify_socket.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdlib>
#include <string>

namespace marco::procman {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A child of this process that says `text` and then stays.
class Child {
 public:
  Child(const std::string& path, const std::string& text) : pid_(fork()) {
    if (pid_ == 0) {
      say(path, text);
      pause();
      _exit(0);
    }
  }
  ~Child() { end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  static void say(const std::string& path, const std::string& text) {
    const auto address = socket_address(path);
    const Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sendto(socket.get(), text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&*address),
           sizeof *address);
  }
  pid_t pid() const { return pid_; }
  void end() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 private:
  pid_t pid_;
};

class NotifySocketTest : public testing::Test {
 protected:
  NotifySocketTest() { socket_.open(path_); }
  ~NotifySocketTest() override {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
  }
  /// Waits for one datagram.
  void receive(pid_t main = 0) {
    pollfd source = {socket_.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&source, 1, 10'000), 1);
    socket_.receive(main);
  }

  std::string path_ = testing::TempDir() + "notify_" + std::to_string(getpid());
  NotifySocket socket_;
};

TEST_F(NotifySocketTest, ItsNameIsInTheEnvironmentAndEndsWithIt) {
  EXPECT_EQ(std::getenv("NOTIFY_SOCKET"), path_);
  {
    NotifySocket other;
    other.open(path_ + "x");
    EXPECT_EQ(access((path_ + "x").c_str(), F_OK), 0);
  }
  EXPECT_NE(access((path_ + "x").c_str(), F_OK), 0);
}

TEST_F(NotifySocketTest, APromiseEndsWithItsProcess) {
  Child child(path_, "READY=1\nWATCHDOG=1\nSTATUS=fine\n");
  receive();
  EXPECT_TRUE(socket_.next_due_us());
  child.end();
  EXPECT_FALSE(socket_.is_silent(0));
  EXPECT_FALSE(socket_.next_due_us());
}

// Its id may be another process's then.
TEST_F(NotifySocketTest, ASurvivorThatEndedIsForgotten) {
  Child child(path_, "OUTLIVES=1");
  receive();
  EXPECT_THAT(socket_.survivors(), ElementsAre(child.pid()));
  child.end();
  EXPECT_THAT(socket_.survivors(), IsEmpty());
}

TEST_F(NotifySocketTest, NeitherTheCommandItselfNorAStrangerOutlives) {
  const Child command(path_, "OUTLIVES=1");
  receive(command.pid());
  Child::say(path_, "OUTLIVES=1\nWATCHDOG=1");  // this process is no child of its own
  Child::say(path_, "");
  receive();
  EXPECT_THAT(socket_.survivors(), IsEmpty());
  EXPECT_FALSE(socket_.next_due_us());
}

}  // namespace
}  // namespace marco::procman
