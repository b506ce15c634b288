// The spy's screen, driven through tmux.
#include <fstream>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/process/spy/spy_rig.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco {
namespace {

using namespace marco::testing;  // NOLINT(google-build-using-namespace): its rig

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
  /// How long the spy was ready to run and had no processor.
  double starved_s() {
    std::ifstream children("/proc/" + pane() + "/task/" + pane() + "/children");
    std::string spy;
    children >> spy;
    double ran_ns = 0.0, waited_ns = 0.0;
    std::ifstream("/proc/" + spy + "/schedstat") >> ran_ns >> waited_ns;
    return 1e-9 * waited_ns;
  }

 private:
  std::string pane() {
    std::string pid = tmux("display-message -p '#{pane_pid}'");
    return pid.substr(0, pid.find('\n'));
  }
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

// "1/2": where Marco's own types are built in, they have the fingerprints of those in tests/types.
TEST(SpyScreen, IsDrivenByKeys) {
  if (!have_tmux()) return;
  const Publisher publisher;
  Terminal terminal("--types tests/types");
  EXPECT_SHOWS(terminal, "POSE +pose2_t (1/2 )?.robot. +[0-9]+ +[0-9.]+ ");
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

// From any screen every robot is stopped; what lets them move again is asked first.
TEST(SpyScreen, StopsEveryRobotAndReleasesThemWhenAsked) {
  if (!have_tmux()) return;
  process::LcmBus bus("");
  process::DropCounter drops;
  std::vector<emergency_stop_t> heard;
  bus.subscribe<emergency_stop_t>(
      "EMERGENCY_STOP", drops, [&](const auto& message, const auto&) { heard.push_back(message); });
  const auto hear = [&](std::size_t count) {
    for (int i = 0; i < 400 && heard.size() < count; ++i) bus.handle_once(50);
    return heard.size() >= count;
  };
  Terminal terminal("");
  EXPECT_SHOWS(terminal, "no messages yet");
  EXPECT_SHOWS(terminal, "To receive messages");
  terminal.press("x");
  ASSERT_TRUE(hear(2));  // more than one: a datagram may be lost
  EXPECT_EQ(heard.back().engaged, 1);
  EXPECT_EQ(heard.back().sender, "marco-spy");
  EXPECT_SHOWS(terminal, "EMERGENCY STOP by marco-spy: stop key");
  terminal.press("X");
  EXPECT_SHOWS(terminal, "Release the emergency stop");
  terminal.press("n");
  EXPECT_SHOWS(terminal, "EMERGENCY STOP by marco-spy");
  terminal.press("X");
  EXPECT_SHOWS(terminal, "Release the emergency stop");
  terminal.press("y");
  while (heard.back().engaged != 0 && hear(heard.size() + 1)) continue;
  EXPECT_EQ(heard.back().engaged, 0);
  EXPECT_SHOWS(terminal, "w who  x stop");
  // Who quits at once has given the order all the same.
  heard.clear();
  terminal.press("x");
  terminal.press("q");
  EXPECT_TRUE(hear(2));
}

// 10 frames a second of the time in which it had a processor, while 100 000 messages a second come
// in: at most one frame in ten is late.
TEST(SpyScreen, StaysAtTenFramesASecondUnderLoad) {
  if (!have_tmux()) return;
  Terminal terminal("");
  terminal.shows("no messages yet");
  Flood flood;
  flood.send_paced(100000, 2);
  std::this_thread::sleep_for(milliseconds(200));
  flood.send(1);
  terminal.shows("POSE");
  const double starved_s = terminal.starved_s();
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
  const double frames_per_s = static_cast<double>(frames) / (seconds - starved_s);
  EXPECT_GE(frames_per_s, 9.0);
  std::printf("%.1f frames/s, %.1f of %.1f s without a processor, sent %lld, lost %lld\n",
              frames_per_s, starved_s, seconds, static_cast<long long>(flood.sent()), lost);
}

TEST(SpyScreen, PlaysALogAndStopsItsClock) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  if (!have_tmux() || data == nullptr) {
    std::puts("SKIPPED: needs tmux and MARCO_TEST_DATA");
    return;
  }
  // However long the path is, the screen's title still says what the log does.
  Terminal terminal(std::string(data) + "/../" + fs::path(data).filename().string() +
                    "/mbot/mbot_convex.lcmlog --speed 20 --types tests/types");
  EXPECT_SHOWS(terminal, "RPLIDAR_LASER +lidar_raw_t (1/2 )?.robot");
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
