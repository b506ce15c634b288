#include "lcm_tools/tests/process/spy/spy_rig.hpp"

#include <fstream>

#include "lcm_tools/files/event_log.hpp"

// The spy as a person runs it, in a network namespace of its own: this process publishes.
namespace marco {
namespace {

using namespace marco::testing;  // NOLINT(google-build-using-namespace): its rig

TEST(Spy, HearsDecodesAndNamesTheSender) {
  const Publisher publisher;
  const json report = spy_json("--duration 2 --types tests/types");
  ASSERT_TRUE(report.is_object()) << report;
  const json pose = channel_named(report, "POSE");
  EXPECT_EQ(pose["type"], "robot.pose2_t");
  // A loaded machine sleeps longer, but as long for both channels.
  const auto hz = pose["hz"].get<double>();
  EXPECT_NEAR(hz / channel_named(report, "LIDAR")["hz"].get<double>(), 10, 2);
  EXPECT_GT(hz, 100.0 / 5.0);
  EXPECT_LT(hz, 105);
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
    EXPECT_THAT(report["findings"].dump(), HasSubstr("marco-spy's receive buffer overflowed"));
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
      spy_json(std::string(data) +
               "/mbot/mbot_convex.lcmlog --types tests/types --types tests/process/spy/types");
  EXPECT_EQ(channel_named(report, "RPLIDAR_LASER")["type"], "mbot_lcm_msgs.lidar_t");
  EXPECT_GE(channel_named(report, "RPLIDAR_LASER")["candidates"].size(), 2U);
  EXPECT_EQ(channel_named(report, "TRUE_POSE")["undecodable"], 0);
}

TEST(Spy, MistakesOnTheCommandLineAreSaid) {
  EXPECT_THAT(output_of(spy() + "--once --lcm-url memq:// 2>&1"), HasSubstr("udpm://"));
  EXPECT_THAT(output_of(spy() + "/no/such/log --once 2>&1"), HasSubstr("/no/such/log"));
  EXPECT_THAT(output_of(spy() + "< /dev/null 2>&1 | cat"), HasSubstr("needs a terminal"));
  EXPECT_THAT(spy_json("--duration 0.1 --types /no/such/types")["problems"][0].get<std::string>(),
              HasSubstr("/no/such/types"));
}

}  // namespace
}  // namespace marco
