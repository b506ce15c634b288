#include "lcm_tools/process/heartbeat.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <vector>

namespace marco::process {
namespace {

/// What systemd or a keeper would get. The name goes into $NOTIFY_SOCKET; '@...' is an abstract
/// one.
class Supervisor {
 public:
  explicit Supervisor(const std::string& name) : name_(name) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path, name.size());
    if (name[0] == '@') address.sun_path[0] = '\0';
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address),
                   static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size())),
              0);
    setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~Supervisor() {
    unsetenv("NOTIFY_SOCKET");
    close(socket_);
    if (name_[0] != '@') unlink(name_.c_str());
  }

  std::vector<std::string> heard() const {
    std::vector<std::string> all;
    char bytes[100];
    for (ssize_t size = 0; (size = recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT)) >= 0;) {
      all.emplace_back(bytes, static_cast<std::size_t>(size));
    }
    return all;
  }

 private:
  std::string name_;
  int socket_ = socket(AF_UNIX, SOCK_DGRAM, 0);
};

using Lines = std::vector<std::string>;
constexpr std::chrono::steady_clock::time_point kBegin{std::chrono::hours(1)};

TEST(Heartbeat, SpeaksSystemdsProtocolAndNotTooOften) {
  const std::string id = std::to_string(getpid());
  for (const std::string& name : {::testing::TempDir() + "beat_" + id, "@marco_beat_" + id}) {
    const Supervisor supervisor(name);
    Heartbeat heartbeat;
    for (int ms = 0; ms < 300; ++ms) heartbeat.beat(kBegin + std::chrono::milliseconds(ms));
    heartbeat.stopping();
    EXPECT_EQ(supervisor.heard(), (Lines{"WATCHDOG=1", "WATCHDOG=1", "WATCHDOG=1", "STOPPING=1"}))
        << name;
  }
}

// Would hang.
TEST(Heartbeat, NeverWaitsForASupervisorThatDoesNotRead) {
  const Supervisor supervisor("@marco_full_" + std::to_string(getpid()));
  Heartbeat heartbeat;
  for (int i = 0; i < 100'000; ++i) heartbeat.beat(kBegin + std::chrono::seconds(i));
  EXPECT_LT(supervisor.heard().size(), 100'000U);
}

TEST(Heartbeat, IsSilentWithoutASupervisor) {
  for (const std::string& name :
       {std::string("/nonexistent/socket"), std::string(300, 'x'), std::string("@")}) {
    setenv("NOTIFY_SOCKET", name.c_str(), 1);
    Heartbeat heartbeat;
    heartbeat.beat();
    heartbeat.stopping();
    EXPECT_FALSE(outlive()) << name;
  }
  unsetenv("NOTIFY_SOCKET");
  Heartbeat().beat();
  EXPECT_FALSE(outlive());
}

}  // namespace
}  // namespace marco::process
