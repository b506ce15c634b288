#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "bot_core/planar_lidar_t.hpp"
#include "common/files/event_log.hpp"
#include "marco/pose2_t.hpp"

// The spy as a person runs it, in a network namespace of its own: this process publishes.
namespace marco {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

std::string spy() {
  const char* folder = std::getenv("MARCO_BIN");
  return std::string(folder == nullptr ? "." : folder) + "/marco-spy ";
}

std::string output_of(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string result;
  std::array<char, 4096> part;
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe))
    result.append(part.data(), count);
  pclose(pipe);
  return result;
}

json spy_json(const std::string& arguments) {
  const std::string text = output_of("timeout 30 " + spy() + arguments + " --once --json");
  return json::accept(text) ? json::parse(text) : json(text);
}

json channel_named(const json& report, const std::string& name) {
  for (const json& channel : report["channels"]) {
    if (channel["channel"] == name) return channel;
  }
  return {};
}

bool own_namespace() { return output_of("ip -o link").find("2:") == std::string::npos; }

/// Publishes POSE at 100 Hz and LIDAR at 10 Hz until destroyed.
class Publisher {
 public:
  explicit Publisher(const std::string& url = "") : lcm_(url), thread_([this] { run(); }) {}
  ~Publisher() {
    stop_ = true;
    thread_.join();
  }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

 private:
  void run() {
    bot_core::planar_lidar_t lidar = {};
    lidar.nranges = 360;
    lidar.radstep = 0.0174533F;
    lidar.ranges.assign(360, 2.5F);
    for (int i = 0; !stop_; ++i) {
      pose2_t pose = {};
      pose.x_m = i % 100;
      lcm_.publish("POSE", &pose);
      if (i % 10 == 0) lcm_.publish("LIDAR", &lidar);
      if (i % 10 == 0) lcm_.publish("LCM_SELF_TEST", "x", 1);
      std::this_thread::sleep_for(milliseconds(10));
    }
  }

  lcm::LCM lcm_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

TEST(Spy, HearsDecodesAndNamesTheSender) {
  const Publisher publisher;
  const json report = spy_json("--duration 2");
  ASSERT_TRUE(report.is_object()) << report;
  const json pose = channel_named(report, "POSE");
  EXPECT_EQ(pose["type"], "marco.pose2_t");
  EXPECT_NEAR(pose["hz"].get<double>(), 95, 30);  // a loaded machine sleeps longer
  EXPECT_GE(pose["last"]["x_m"], 0);
  EXPECT_EQ(pose["undecodable"], 0);
  EXPECT_EQ(channel_named(report, "LIDAR")["last"]["ranges"].size(), 360U);
  const json self_test = channel_named(report, "LCM_SELF_TEST");
  EXPECT_EQ(self_test["untyped"], self_test["count"]);
  ASSERT_EQ(report["senders"].size(), 1U);
  EXPECT_EQ(report["senders"][0]["process"], "spy_process_test");
  EXPECT_EQ(report["senders"][0]["pid"], getpid());
  EXPECT_EQ(report["senders"][0]["channels"].size(), 3U);
  EXPECT_EQ(report["lost"], 0);
}

// What a sender does, without liblcm's cost, so that the numbers are known exactly.
class Flood {
 public:
  Flood() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    const char* url = std::getenv("LCM_DEFAULT_URL");
    const std::string text = url == nullptr ? "udpm://239.255.76.67:7667" : url;
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<uint16_t>(std::atoi(text.c_str() + text.rfind(':') + 1)));
    inet_pton(AF_INET, "239.255.76.67", &group_.sin_addr);
    const unsigned char stay = 0;
    ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &stay, sizeof stay);
    const pose2_t pose = {};
    std::memcpy(bytes_.data(), "LC02", 4);
    std::memcpy(bytes_.data() + 8, "POSE", 5);
    size_ = 13 + static_cast<std::size_t>(pose.encode(bytes_.data() + 13, 0, 100));
  }
  ~Flood() { ::close(socket_); }
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  void send(int count) {
    for (; count > 0; --count, ++sent_) {
      const uint32_t number = htonl(static_cast<uint32_t>(sent_));
      std::memcpy(bytes_.data() + 4, &number, 4);
      ::sendto(socket_, bytes_.data(), size_, 0, reinterpret_cast<const sockaddr*>(&group_),
               sizeof group_);
    }
  }
  void send_paced(int per_second, double seconds) {
    const auto start = std::chrono::steady_clock::now();
    const int64_t first = sent_;
    const auto all = static_cast<int64_t>(per_second * seconds);
    while (sent_ - first < all) {
      const double elapsed_s =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      send(static_cast<int>(std::min(all, static_cast<int64_t>(elapsed_s * per_second)) -
                            (sent_ - first)));
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  }
  int64_t sent() const { return sent_; }

 private:
  int socket_;
  sockaddr_in group_ = {};
  std::array<uint8_t, 128> bytes_ = {};
  std::size_t size_ = 0;
  int64_t sent_ = 0;
};

/// A spy that listens until it is told to stop; ready when its socket is bound.
class ListeningSpy {
 public:
  explicit ListeningSpy(const std::string& arguments)
      : pid_file_(fs::temp_directory_path() / ("marco_spy_pid_" + std::to_string(getpid()))) {
    fs::remove(pid_file_);
    const std::string command = "echo $$ > " + pid_file_.string() + "; exec " + spy() +
                                "--once --json --duration 60 " + arguments;
    thread_ = std::thread([this, command] { text_ = output_of(command); });
    while (pid() == 0 ||
           output_of("ls -l /proc/" + std::to_string(pid()) + "/fd").find("socket:") ==
               std::string::npos) {
      std::this_thread::sleep_for(milliseconds(20));
    }
    std::this_thread::sleep_for(milliseconds(300));
  }
  ~ListeningSpy() { fs::remove(pid_file_); }
  ListeningSpy(const ListeningSpy&) = delete;
  ListeningSpy& operator=(const ListeningSpy&) = delete;

  json stop() {
    ::kill(pid(), SIGTERM);
    thread_.join();
    return json::accept(text_) ? json::parse(text_) : json(text_);
  }

 private:
  int pid() const {
    std::ifstream file(pid_file_);
    int result = 0;
    file >> result;
    return result;
  }
  fs::path pid_file_;
  std::string text_;
  std::thread thread_;
};

// Sender and spy on one core. Every message is received or reported lost; with a small buffer some
// are lost, and the sum still holds.
TEST(Spy, HundredThousandMessagesASecondAreAllAccountedFor) {
  cpu_set_t before;
  cpu_set_t one;
  sched_getaffinity(0, sizeof before, &before);
  CPU_ZERO(&one);
  for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++i) {
    if (CPU_ISSET(i, &before)) CPU_SET(i, &one);
  }
  sched_setaffinity(0, sizeof one, &one);  // the spy inherits it
  for (const std::string buffer : {"", "recv_buf_size=4096"}) {
    const char* url = std::getenv("LCM_DEFAULT_URL");
    const std::string base = url == nullptr ? "udpm://239.255.76.67:7667?" : std::string(url) + "&";
    ListeningSpy listener("--lcm-url '" + base + buffer + "'");
    Flood flood;
    flood.send(1);  // the first number tells the spy where it begins
    flood.send_paced(100000, 1);
    std::this_thread::sleep_for(milliseconds(700));
    flood.send(1);  // and the last one what is missing
    std::this_thread::sleep_for(milliseconds(300));
    const json report = listener.stop();
    ASSERT_TRUE(report.is_object()) << report;
    const auto received = report["received"].get<int64_t>();
    const auto lost = report["lost"].get<int64_t>();
    EXPECT_EQ(received + lost, flood.sent());
    EXPECT_EQ(channel_named(report, "POSE")["lost"], lost);
    std::printf("%s: sent %lld, received %lld, lost %lld\n",
                buffer.empty() ? "own buffer" : buffer.c_str(),
                static_cast<long long>(flood.sent()), static_cast<long long>(received),
                static_cast<long long>(lost));
    if (buffer.empty()) continue;
    EXPECT_GT(lost, 0);
    EXPECT_THAT(report["findings"].dump(), HasSubstr("this spy's receive buffer overflowed"));
  }
  sched_setaffinity(0, sizeof before, &before);
}

TEST(Spy, FindsOutWhyItHearsNothingAndTheCommandMendsIt) {
  if (!own_namespace()) {
    std::puts("SKIPPED: needs a network namespace of its own");
    return;
  }
  struct Fault {
    const char* breaks;
    const char* said;
  };
  for (const Fault fault : {Fault{"ip route del 224.0.0.0/4", "no route leads to"},
                            {"ip link set lo multicast off", "no multicast flag"},
                            {"ip link set lo down",
                             "no route leads to 239.255.76.67: no process can publish, and the "
                             "loopback interface is down"}}) {
    ASSERT_EQ(std::system(fault.breaks), 0);
    json report = spy_json("--duration 0.2");
    EXPECT_EQ(report["received"], 0) << report;
    const json finding = report["findings"][0];
    EXPECT_THAT(finding["text"].get<std::string>(), HasSubstr(fault.said));
    std::string mend = finding["command"];
    for (std::size_t at = mend.find("sudo "); at != std::string::npos; at = mend.find("sudo "))
      mend.erase(at, 5);
    EXPECT_EQ(std::system(mend.c_str()), 0) << mend;
    const Publisher publisher;
    report = spy_json("--duration 0.5");
    EXPECT_GT(report["received"], 0) << fault.breaks;
  }
}

TEST(Spy, NamesTheOtherUrlOnWhichMessagesAreHeard) {
  const Publisher publisher("udpm://239.255.76.67:7999?ttl=0");
  const json report = spy_json("--duration 0.5 --lcm-url udpm://239.255.76.67:7998");
  if (own_namespace()) {
    EXPECT_EQ(report["findings"][0]["command"], "marco-spy --lcm-url 'udpm://239.255.76.67:7999'")
        << report;
  }
  EXPECT_EQ(report["received"], 0);
}

TEST(Spy, ReadsALogWithTypesOfItsReader) {
  const std::string path =
      fs::temp_directory_path() / ("marco_spy_" + std::to_string(getpid()) + ".lcm");
  {
    files::EventLogWriter writer(path);
    std::vector<uint8_t> bytes(28);
    for (unsigned i = 0; i < 8; ++i)
      bytes[i] = static_cast<uint8_t>(0x85d72aee83523195U >> (56 - 8 * i));  // twist2D_t
    for (int i = 0; i < 100; ++i) writer.write("MBOT_VEL", bytes, Utime::from_us(50000 * i));
  }
  EXPECT_EQ(channel_named(spy_json(path), "MBOT_VEL")["unknown_type"], 100);
  const json channel =
      channel_named(spy_json(path + " --types tests/process/spy/types"), "MBOT_VEL");
  EXPECT_EQ(channel["type"], "mbot_lcm_msgs.twist2D_t");
  EXPECT_EQ(channel["undecodable"], 0);
  EXPECT_EQ(channel["hz"], 20);
  EXPECT_EQ(channel["last"]["wz"], 0);
  EXPECT_EQ(channel_named(spy_json(path + " --duration 1"), "MBOT_VEL")["count"], 21);
  fs::remove(path);
}

TEST(Spy, ReadsARealLogOfAForeignRobot) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  if (data == nullptr) {
    std::puts("SKIPPED: MARCO_TEST_DATA is not set");
    return;
  }
  const json report =
      spy_json(std::string(data) + "/mbot/mbot_convex.lcmlog --types tests/process/spy/types");
  EXPECT_EQ(channel_named(report, "RPLIDAR_LASER")["type"], "mbot_lcm_msgs.lidar_t");
  EXPECT_EQ(channel_named(report, "RPLIDAR_LASER")["candidates"].size(), 2U);
  EXPECT_EQ(channel_named(report, "TRUE_POSE")["undecodable"], 0);
}

TEST(Spy, MistakesOnTheCommandLineAreSaid) {
  EXPECT_THAT(output_of(spy() + "--once --lcm-url memq:// 2>&1"), HasSubstr("udpm://"));
  EXPECT_THAT(output_of(spy() + "/no/such/log --once 2>&1"), HasSubstr("/no/such/log"));
  EXPECT_THAT(output_of(spy() + "< /dev/null 2>&1 | cat"), HasSubstr("needs a terminal"));
  EXPECT_THAT(spy_json("--duration 0.1 --types /no/such/types")["problems"][0].get<std::string>(),
              HasSubstr("/no/such/types"));
}

/// A terminal of 110 x 24 with the spy in it, driven by keys.
class Terminal {
 public:
  explicit Terminal(const std::string& arguments) : name_("marco_spy_" + std::to_string(getpid())) {
    tmux("kill-server 2>/dev/null");
    tmux("-u -f /dev/null new-session -d -x 110 -y 24 \"" + spy() + arguments + "; sleep 20\"");
  }
  ~Terminal() { tmux("kill-server 2>/dev/null"); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void press(const std::string& keys) { tmux("send-keys " + keys); }
  /// The screen as soon as it shows `text` (extended regular expression), or after 20 s.
  std::string shows(const std::string& text) {
    std::string screen;
    for (int i = 0; i < 400; ++i) {
      screen = tmux("capture-pane -p");
      if (::testing::internal::RE::PartialMatch(screen, text)) break;
      std::this_thread::sleep_for(milliseconds(50));
    }
    return screen;
  }

 private:
  std::string tmux(const std::string& arguments) {
    return output_of("LC_ALL=C.UTF-8 timeout 10 tmux -L " + name_ + " " + arguments);
  }
  std::string name_;
};

bool have_tmux() {
  if (!output_of("command -v tmux").empty()) return true;
  std::puts("SKIPPED: tmux is not installed");
  return false;
}

#define EXPECT_SHOWS(terminal, text) \
  EXPECT_THAT((terminal).shows(text), ::testing::ContainsRegex(text))

TEST(SpyScreen, IsDrivenByKeys) {
  if (!have_tmux()) return;
  const Publisher publisher;
  Terminal terminal("");
  EXPECT_SHOWS(terminal, "POSE +marco.pose2_t +[0-9]+ +[0-9.]+ ");
  EXPECT_SHOWS(terminal, "LCM_SELF_TEST +no type");
  terminal.press("/ lidar Enter");
  EXPECT_SHOWS(terminal, "filter: lidar");
  EXPECT_THAT(terminal.shows("filter: lidar"), ::testing::Not(HasSubstr("pose2_t")));
  terminal.press("Enter");
  EXPECT_SHOWS(terminal, "ranges +float.360.");
  terminal.press("v");
  EXPECT_SHOWS(terminal, "360 of 360 beams, ahead is up");
  terminal.press("Escape");
  EXPECT_SHOWS(terminal, "ranges +float.360.");
  terminal.press("Escape");
  EXPECT_SHOWS(terminal, "filter: lidar");
  terminal.press("Escape");
  EXPECT_SHOWS(terminal, "pose2_t");
  terminal.press("End");
  terminal.press("Enter");
  EXPECT_SHOWS(terminal, "x_m +double +[0-9]+ +.*[▁▂▃▄▅▆▇█]");
  terminal.press("Down");
  terminal.press("g");
  EXPECT_SHOWS(terminal, "x_m = [0-9]+");
  terminal.press("w");
  EXPECT_SHOWS(terminal, "spy_process_test \\([0-9]+\\)");
  EXPECT_SHOWS(terminal, "──▶ POSE");
  EXPECT_SHOWS(terminal, "this spy +lost 0");
  terminal.press("p");
  EXPECT_SHOWS(terminal, "PAUSED");
  terminal.press("q");
  EXPECT_SHOWS(terminal, "[0-9]+ messages received, 0 lost");
}

// 10 frames a second while 100 000 messages a second come in: at most one frame in ten is late.
TEST(SpyScreen, StaysAtTenFramesASecondUnderLoad) {
  if (!have_tmux()) return;
  Terminal terminal("");
  terminal.shows("nothing heard yet");
  Flood flood;
  flood.send_paced(100000, 2);
  std::this_thread::sleep_for(milliseconds(200));
  flood.send(1);
  terminal.shows("POSE");
  terminal.press("q");
  const std::string screen = terminal.shows("frames in [0-9.]+ s");
  long long received = 0;
  long long lost = 0;
  long long frames = 0;
  double seconds = 0;
  const std::size_t line = screen.find(" messages received");
  ASSERT_NE(line, std::string::npos) << screen;
  const std::size_t begin =
      screen.rfind('\n', line) == std::string::npos ? 0 : screen.rfind('\n', line) + 1;
  ASSERT_EQ(
      std::sscanf(screen.c_str() + begin, "%lld messages received, %lld lost, %lld frames in %lf s",
                  &received, &lost, &frames, &seconds),
      4)
      << screen;
  EXPECT_EQ(received + lost, flood.sent());
  EXPECT_GE(static_cast<double>(frames) / seconds, 9.0);
  std::printf("%.1f frames/s, sent %lld, lost %lld\n", static_cast<double>(frames) / seconds,
              static_cast<long long>(flood.sent()), lost);
}

TEST(SpyScreen, PlaysALogAndStopsItsClock) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  if (!have_tmux() || data == nullptr) {
    std::puts("SKIPPED: needs tmux and MARCO_TEST_DATA");
    return;
  }
  // However long the path is, the screen's title still says what the log does.
  Terminal terminal(std::string(data) + "/../" + fs::path(data).filename().string() +
                    "/mbot/mbot_convex.lcmlog --speed 20");
  EXPECT_SHOWS(terminal, "RPLIDAR_LASER +marco.lidar_raw_t");
  terminal.press("p");
  const std::string paused = terminal.shows("PAUSED");
  std::this_thread::sleep_for(milliseconds(400));
  EXPECT_EQ(terminal.shows("PAUSED"), paused);
  terminal.press("p");
  EXPECT_SHOWS(terminal, "end of the log");
  EXPECT_SHOWS(terminal, "TRUE_POSE .* 2103 ");
}

}  // namespace
}  // namespace marco
