// The laser drivers as processes: real pseudo-terminals and sockets, real LCM.
#include <gmock/gmock.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/process_status_t.hpp"
#include "simulator/devices/cola/emulator.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "simulator/devices/ldlidar/emulator.hpp"
#include "simulator/devices/leuze/emulator.hpp"
#include "simulator/devices/leuze/service_emulator.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/transport/emulator_port.hpp"
#include "simulator/devices/ydlidar/emulator.hpp"

extern char** environ;

namespace marco::drivers {
namespace {

// What takes a second or two may take this long on a machine that stands still now and then.
constexpr double kPatienceS = 40.0;

// A driver started from the build's programs; ended with SIGTERM.
class Driver {
 public:
  Driver(const std::string& program, const std::string& device, const std::string& config) {
    config_path_ =
        (std::filesystem::temp_directory_path() / (program + std::to_string(getpid()) + ".toml"))
            .string();
    std::ofstream(config_path_) << config;
    const char* folder = std::getenv("MARCO_BIN");
    const std::string path =
        std::string(folder != nullptr ? folder : "build/dev/bin") + "/" + program;
    std::vector<std::string> words{path,   "--config",    config_path_, "--device",
                                   device, "--log-level", "error"};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    EXPECT_EQ(posix_spawn(&pid_, path.c_str(), nullptr, nullptr, arguments.data(), environ), 0);
  }
  ~Driver() {
    stop();
    std::filesystem::remove(config_path_);
  }
  // @returns its exit code; -1 when it did not end by itself.
  int stop() {
    if (pid_ <= 0) return 0;
    kill(pid_, SIGTERM);
    return wait();
  }
  void signal(int number) const { kill(pid_, number); }
  int wait() {
    int status = 0;
    rusage usage{};
    wait4(std::exchange(pid_, 0), &status, 0, &usage);
    cpu_s_ = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
             1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  double cpu_s() const { return cpu_s_; }
  // Since it was started: how long its threads were ready to run and had no processor.
  double starved_s() const {
    double sum_ns = 0.0;
    const std::string threads = "/proc/" + std::to_string(pid_) + "/task";
    for (const auto& thread : std::filesystem::directory_iterator(threads)) {
      double ran_ns = 0.0, waited_ns = 0.0;
      std::ifstream(thread.path() / "schedstat") >> ran_ns >> waited_ns;
      sum_ns += waited_ns;
    }
    return 1e-9 * sum_ns;
  }

 private:
  pid_t pid_ = 0;
  std::string config_path_;
  double cpu_s_ = 0.0;
};

// What came over LCM; pumps it, and the emulator's port, in one thread.
class Stage {
 public:
  explicit Stage(EmulatorPort& port) : port_(port), bus_("") {
    bus_.subscribe_raw(".*", [this](const process::RawMessage& raw) { take(raw); });
  }
  template <class Condition>
  bool run_until(double limit_s, Condition condition) {
    std::array<EmulatorPort*, 1> ports{&port_};
    const Utime limit = wall_now() + Duration::from_seconds(limit_s);
    Utime before = wall_now();
    while (!condition() && wall_now() < limit) {
      serve_ports(ports, Duration::from_us(1000));
      while (bus_.handle_once(0)) {
      }
      const Utime now = wall_now();
      const double took_s = (now - std::exchange(before, now)).seconds();
      if (took_s > 0.05) stood_still_s += took_s;
    }
    return condition();
  }
  std::vector<LaserScan> scans;  // lidar_raw_t
  std::vector<LaserScan> planar_scans;
  std::vector<float> intensities;  // of the last one
  std::optional<SensorInfo> info;
  std::string state;
  double latency_max_s = 0.0;
  double stood_still_s = 0.0;  // this machine, and with it the emulator

 private:
  // lidar_raw_t comes first, then the same scan as planar_lidar_t.
  void expect_the_scan_before() const {
    ASSERT_FALSE(scans.empty());
    const LaserScan& raw = scans.back();
    const LaserScan& planar = planar_scans.back();
    EXPECT_EQ(planar.utime, raw.utime);
    EXPECT_EQ(channels::raw_channel_of(planar.channel), raw.channel);
    ASSERT_EQ(planar.size(), raw.size());
    EXPECT_NEAR(planar.bearing_rad(0), raw.bearing_rad(0), 1e-6);
    EXPECT_TRUE(planar.time_offsets_s.empty());
    EXPECT_EQ(raw.time_offsets_s.size(), raw.size());
  }
  void take(const process::RawMessage& message) {
    const std::string channel(message.channel);
    if (channel == channels::kProcessStatus) {
      process_status_t status;
      status.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size()));
      state = status.state;
      latency_max_s = std::max(latency_max_s, status.latency_max_s);
      return;
    }
    auto sample = decode_sample(channel, message.bytes);
    if (!sample) return;
    if (auto* found = std::get_if<SensorInfo>(&*sample)) info = *found;
    auto* scan = std::get_if<LaserScan>(&*sample);
    if (scan == nullptr) return;
    const bool raw = channels::is_raw_lidar(channel);
    if (raw) {
      lidar_raw_t whole;
      whole.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size()));
      intensities = whole.intensities;
    }
    (raw ? scans : planar_scans).push_back(std::move(*scan));
    if (!raw) expect_the_scan_before();
  }

  EmulatorPort& port_;
  process::LcmBus bus_;
};

std::vector<double> flat_wall(const LaserSweep& sweep) {
  std::vector<double> ranges_m;
  for (int i = 0; i < sweep.beams; ++i) {
    const double bearing_rad = sweep.first_bearing_rad + i * sweep.bearing_step_rad;
    ranges_m.push_back(std::cos(bearing_rad) > 0.1 ? 2.0 / std::cos(bearing_rad) : 2.5);
  }
  return ranges_m;
}

// The wall, and in each turn's first beam, as a millimetre a turn, which turn it was: the scans
// tell of themselves when they were measured.
class NumberedTurns {
 public:
  std::vector<double> turn(const LaserSweep& sweep) {
    std::vector<double> ranges_m = flat_wall(sweep);
    ranges_m[0] = kFirstM + 0.001 * static_cast<double>(first_beams_.size());
    first_beams_.push_back(sweep.first_beam);
    return ranges_m;
  }
  /// What the scan's stamp is later than its first beam was measured.
  double stamp_error_s(const LaserScan& scan) const {
    const auto turn = std::lround((static_cast<double>(scan.ranges_m[0]) - kFirstM) * 1000.0);
    return (scan.utime - first_beams_.at(static_cast<std::size_t>(turn))).seconds() +
           static_cast<double>(scan.time_offsets_s.at(0));
  }

 private:
  static constexpr double kFirstM = 2.5;
  std::vector<Utime> first_beams_;
};

// Of a driver, since this began: the fraction of the time in which it had no processor.
class Starvation {
 public:
  explicit Starvation(const Driver& driver)
      : driver_(driver), begun_(wall_now()), before_s_(driver.starved_s()) {}
  double fraction() const {
    return (driver_.starved_s() - before_s_) / (wall_now() - begun_).seconds();
  }

 private:
  const Driver& driver_;
  Utime begun_;
  double before_s_;
};

// Half of the scans from `first` on, unless the emulator stood still, as no laser does, or the
// driver had no processor for a fifth of the time.
void expect_right_stamps(const Stage& stage,
                         const Starvation& starvation,
                         const NumberedTurns& turns,
                         std::size_t first) {
  const double starved = starvation.fraction();
  if (stage.stood_still_s > 0.2 || starved > 0.2) {
    std::printf("stamps not judged: emulator stood still for %.1f s, driver starved for %.0f %%\n",
                stage.stood_still_s, 100.0 * starved);
    return;
  }
  std::vector<double> errors_s;
  for (std::size_t i = first; i < stage.scans.size(); ++i) {
    errors_s.push_back(turns.stamp_error_s(stage.scans[i]));
  }
  const auto middle = errors_s.begin() + static_cast<std::ptrdiff_t>(errors_s.size() / 2);
  std::nth_element(errors_s.begin(), middle, errors_s.end());
  EXPECT_NEAR(*middle, 0.0, 0.03);
}

// Of a scan of the wall 2 m ahead: the beam straight ahead.
double ahead_m(const LaserScan& scan) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (std::abs(scan.bearing_rad(i)) < std::abs(scan.bearing_rad(best))) best = i;
  }
  return static_cast<double>(scan.ranges_m[best]);
}

TEST(LaserProcess, SickLivesThroughItsLasersTroubles) {
  sick::SickEmulatorOptions device;
  device.power_on_s = 0.5;
  NumberedTurns turns;
  sick::SickEmulator emulator([&](const LaserSweep& sweep) { return turns.turn(sweep); }, device);
  const std::string link =
      (std::filesystem::temp_directory_path() / ("marco_sick_" + std::to_string(getpid())))
          .string();
  EmulatorPort port = EmulatorPort::pty(emulator, link);
  Stage stage(port);
  Driver driver("marco-sick", link,
                "[place]\nposition_m = [0.1, 0.0, 0.3]\n[sick]\nbaud = 500000\n");
  const Starvation starvation(driver);
  ASSERT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() >= 60; })) << stage.state;
  ASSERT_TRUE(stage.run_until(kPatienceS, [&] {
    return stage.info && stage.state.find("measuring") != std::string::npos;
  })) << stage.state;
  EXPECT_EQ(stage.scans.back().size(), 361u);
  EXPECT_NEAR(ahead_m(stage.scans.back()), 2.0, 0.001);
  EXPECT_EQ(stage.info->channel, "LIDAR");
  EXPECT_NEAR(stage.info->parent_from_sensor.translation().x(), 0.1, 1e-12);
  EXPECT_NEAR(stage.info->range_max_m, 32.759, 1e-5);  // sent as the float its ranges are
  expect_right_stamps(stage, starvation, turns, 0);

  Driver second("marco-sick", link, "");
  EXPECT_EQ(second.wait(), 1);  // refused

  port.unplug();
  EXPECT_TRUE(stage.run_until(kPatienceS, [&] { return stage.state.starts_with("no device"); }))
      << stage.state;
  port.plug_in();
  std::size_t before = stage.scans.size();
  const double stood_still_before_s = stage.stood_still_s;
  const Utime back = wall_now();
  EXPECT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() > before; }))
      << stage.state;
  // A second to reopen, half a second of the device; five times that.
  EXPECT_LT((wall_now() - back).seconds() - (stage.stood_still_s - stood_still_before_s), 7.5);

  emulator.power_cycle(wall_now());
  before = stage.scans.size() + 2;
  EXPECT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() > before; }))
      << stage.state;

  const std::size_t at_start = stage.scans.size();
  EXPECT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() >= at_start + 75; }));
  EXPECT_EQ(driver.stop(), 0);
  EXPECT_TRUE(stage.run_until(kPatienceS, [&] { return !emulator.streaming(); }));
  std::printf("marco-sick at 500000 baud: %.2f s of CPU, %zu scans, worst latency %.2f ms\n",
              driver.cpu_s(), stage.scans.size(), stage.latency_max_s * 1e3);
}

// Of 0.6 s to 1.4 s: the driver hears nothing of them, or finds them all in the line at once.
TEST(LaserProcess, AfterTheDriverStoodStillTheStampsAreRight) {
  sick::SickEmulatorOptions device;
  NumberedTurns turns;
  sick::SickEmulator emulator([&](const LaserSweep& sweep) { return turns.turn(sweep); }, device);
  EmulatorPort port = EmulatorPort::pty(emulator);
  Stage stage(port);
  Driver driver("marco-sick", port.address(), "[sick]\nbaud = 500000\n");
  ASSERT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() >= 40; })) << stage.state;
  for (const double pause_s : {0.6, 1.4, 0.8}) {
    driver.signal(SIGSTOP);
    stage.run_until(pause_s, [] { return false; });
    driver.signal(SIGCONT);
    const Starvation starvation(driver);
    const std::size_t before = stage.scans.size();
    ASSERT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() >= before + 40; }))
        << stage.state;
    expect_right_stamps(stage, starvation, turns, before);
  }
  EXPECT_EQ(driver.stop(), 0);
}

// Runs a driver against a port until it has published some scans.
LaserScan one_scan(EmulatorPort& port,
                   const std::string& program,
                   const std::string& config,
                   float intensity = 0.0F) {
  Stage stage(port);
  Driver driver(program, port.address(), config);
  EXPECT_TRUE(stage.run_until(kPatienceS, [&] { return stage.scans.size() >= 8 && stage.info; }))
      << program << ": " << stage.state;
  EXPECT_EQ(driver.stop(), 0);
  EXPECT_THAT(stage.intensities, ::testing::Contains(intensity));
  std::printf("%s: %.3f s of CPU for %zu scans\n", program.c_str(), driver.cpu_s(),
              stage.scans.size());
  return stage.scans.empty() ? LaserScan{} : stage.scans.back();
}

TEST(LaserProcess, TheOthersPublishToo) {
  hokuyo::HokuyoEmulator hokuyo(flat_wall, {});
  EmulatorPort hokuyo_port = EmulatorPort::pty(hokuyo);
  LaserScan scan = one_scan(hokuyo_port, "marco-hokuyo", "[place]\nchannel = \"LIDAR_REAR\"\n");
  EXPECT_EQ(scan.channel, "LIDAR_RAW_REAR");
  EXPECT_NEAR(ahead_m(scan), 2.0, 0.001);

  // As a UST or UTM with Ethernet is reached.
  hokuyo::HokuyoEmulatorOptions ust;
  ust.model = "UST-10LX";
  hokuyo::HokuyoEmulator ethernet(flat_wall, ust);
  EmulatorPort ethernet_port = EmulatorPort::tcp(ethernet, 0);
  EXPECT_NEAR(ahead_m(one_scan(ethernet_port, "marco-hokuyo", "")), 2.0, 0.001);

  // The test asks for intensities: 83 at two metres.
  for (const auto& model : {cola::ColaEmulatorOptions{}, cola::lms111()}) {
    cola::ColaEmulator cola(flat_wall, model);
    EmulatorPort cola_port = EmulatorPort::tcp(cola, 0);
    scan = one_scan(cola_port, "marco-cola", "[cola]\nintensities = true\n", 83.0F);
    EXPECT_NEAR(ahead_m(scan), 2.0, 0.001);
  }

  for (const auto& model : {rplidar::RplidarEmulatorOptions{}, rplidar::s2()}) {
    rplidar::RplidarEmulator rplidar(flat_wall, model);
    EmulatorPort rplidar_port = EmulatorPort::pty(rplidar);
    scan = one_scan(rplidar_port, "marco-rplidar", "");
    EXPECT_EQ(scan.channel, "LIDAR_RAW");
    EXPECT_NEAR(ahead_m(scan), 2.0, 0.001);
  }

  for (const auto& model : {ldlidar::LdlidarEmulatorOptions{}, ldlidar::stl27l()}) {
    ldlidar::LdlidarEmulator ldlidar(flat_wall, model);
    EmulatorPort ldlidar_port = EmulatorPort::pty(ldlidar);
    EXPECT_NEAR(ahead_m(one_scan(ldlidar_port, "marco-ldlidar", "", 200.0F)), 2.0, 0.001);
  }
  for (const auto& model : {ydlidar::x2(), ydlidar::YdlidarEmulatorOptions{}, ydlidar::g4()}) {
    ydlidar::YdlidarEmulator ydlidar(flat_wall, model);
    EmulatorPort ydlidar_port = EmulatorPort::pty(ydlidar);
    EXPECT_NEAR(ahead_m(one_scan(ydlidar_port, "marco-ydlidar", "")), 2.0, 0.001);
  }

  leuze::LeuzeEmulatorOptions over_tcp;
  over_tcp.baud = 0;
  leuze::LeuzeEmulator leuze(flat_wall, over_tcp);
  EmulatorPort leuze_port = EmulatorPort::tcp(leuze, 0);
  scan = one_scan(leuze_port, "marco-leuze", "[leuze]\nbaud = 0\n");
  EXPECT_NEAR(ahead_m(scan), 2.0, 0.003);

  leuze::LeuzeServiceEmulator service(flat_wall, leuze::thesis_a_geometry());
  EmulatorPort service_port = EmulatorPort::tcp(service, 0);
  scan = one_scan(service_port, "marco-leuze",
                  "[leuze]\nservice = true\npoll_s = 0.1\n[leuze.geometry]\nclockwise = false\n"
                  "beam_step_deg = 0.35984848484848486\nscale = 1.077\n");
  EXPECT_NEAR(ahead_m(scan), 2.0, 0.003);
}

}  // namespace
}  // namespace marco::drivers
