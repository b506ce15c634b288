// Each device at each of its rates, and what is none, is named rightly; on emulated lines.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "drivers/devices/listening.hpp"
#include "drivers/devices/questions.hpp"
#include "drivers/devices/robot_files.hpp"
#include "drivers/devices/said_lines.hpp"
#include "drivers/devices/survey.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/transport/paced_output.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "simulator/devices/bno055/emulator.hpp"
#include "simulator/devices/cola/emulator.hpp"
#include "simulator/devices/create/emulator.hpp"
#include "simulator/devices/hcs12/base_emulator.hpp"
#include "simulator/devices/hcs12/pantilt_emulator.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "simulator/devices/imu/emulator.hpp"
#include "simulator/devices/kobuki/emulator.hpp"
#include "simulator/devices/ldlidar/emulator.hpp"
#include "simulator/devices/leuze/emulator.hpp"
#include "simulator/devices/p2os/emulator.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/textbase/emulator.hpp"
#include "simulator/devices/ydlidar/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::devices {
namespace {

std::optional<double> measured(const std::string& /*laser*/) { return 0.18; }

/// What a stranger says: a text every period, at a rate of its own; some echo, some answer a line.
struct StrangerOptions {
  int baud = 9600;
  double period_s = 0.0;  ///< 0 = says nothing by itself
  std::string says;
  bool echoes = false;
  std::string answers_line;  ///< to a line end
};
class Stranger final : public Emulator {
 public:
  explicit Stranger(StrangerOptions options)
      : options_(std::move(options)), output_(options_.baud) {}
  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override {
    readable_ = baud == options_.baud;
    if (!bytes.empty()) heard_.insert(heard_.end(), bytes.begin(), bytes.end());
    if (!readable_) return;
    if (options_.echoes) output_.send(bytes, now);
    const bool line = std::find(bytes.begin(), bytes.end(), '\n') != bytes.end();
    if (line) say(options_.answers_line, now);
  }
  void advance(Utime now, std::vector<uint8_t>& out) override {
    if (options_.period_s > 0.0 && now >= next_) {
      next_ = now + Duration::from_seconds(options_.period_s);
      say(options_.says, now);
    }
    std::vector<uint8_t> sent;
    output_.advance(now, sent);
    // At another rate every bit is read at a wrong time.
    if (!readable_) {
      for (uint8_t& byte : sent) byte = static_cast<uint8_t>(byte * 37 + 0x95);
    }
    out.insert(out.end(), sent.begin(), sent.end());
  }
  Utime next_event() const override {
    return options_.period_s > 0.0 ? std::min(next_, output_.next_event()) : output_.next_event();
  }
  void on_connection(bool, Utime now) override { next_ = now + Duration::from_us(300'000); }
  const Bytes& heard() const { return heard_; }

 private:
  void say(const std::string& text, Utime now) {
    output_.send(std::vector<uint8_t>(text.begin(), text.end()), now);
  }
  StrangerOptions options_;
  PacedOutput output_;
  bool readable_ = true;
  Bytes heard_;
  Utime next_;
};

PortReport look_at(Emulator& emulator,
                   bool ask = true,
                   double powered_s = 0.0,
                   bool named = false) {
  SimulatedLine line(emulator);
  line.wait(Duration::from_seconds(powered_s));
  const auto stream = line.open({rates().front(), Parity::none});
  PortReport report{{"/dev/ttyUSB0", {}, named}, "", ask ? "" : "it is a test", {}, {}};
  const Utime begin = line.now();
  survey_line(
      *stream, [&line] { return line.now(); }, report, false);
  std::printf("%5.1f s: %s\n", (line.now() - begin).seconds(), describe(report).c_str());
  return report;
}

/// @param powered_s  how long it has had power
void expect_found(Emulator& emulator, const std::string& beginning, double powered_s = 0.0) {
  const PortReport report = look_at(emulator, true, powered_s);
  EXPECT_TRUE(describe(report).starts_with(beginning + " on /dev/ttyUSB0")) << describe(report);
  if (may_be_tried(report.finding.claim.kind)) {
    ASSERT_TRUE(report.trial);
    EXPECT_GT(report.trial->scans_per_s, 1.0) << report.trial->state;
  }
}

TEST(Devices, LasersThatOnlyTalkAreFound) {
  ldlidar::LdlidarEmulator ld19(test_world, {});
  expect_found(ld19, "LDROBOT laser at 230400");
  ldlidar::LdlidarEmulator stl27l(test_world, ldlidar::stl27l());
  expect_found(stl27l, "LDROBOT laser at 921600");
  ydlidar::YdlidarEmulator x2(test_world, ydlidar::x2());
  expect_found(x2, "YDLIDAR at 115200");
  for (const int baud : {4800, 9600, 19'200, 38'400, 57'600, 115'200}) {
    leuze::LeuzeEmulatorOptions options;
    options.baud = baud;
    leuze::LeuzeEmulator leuze(test_world, options);
    expect_found(leuze, "Leuze RS4 at " + std::to_string(baud));
  }
}

TEST(Devices, LasersThatAnswerAreFoundAtEachRate) {
  for (const auto& [model, name] : {std::pair{0x18, "A1"}, std::pair{0x28, "A2"}}) {
    for (const int baud : {115'200, 256'000}) {
      rplidar::RplidarEmulatorOptions options;
      options.model = model;
      options.baud = baud;
      rplidar::RplidarEmulator laser(test_world, options);
      expect_found(laser, std::string("RPLIDAR ") + name + " at " + std::to_string(baud));
    }
  }
  for (const auto& options :
       {rplidar::a3(), rplidar::s1(), rplidar::c1(), rplidar::s2(), rplidar::s3()}) {
    rplidar::RplidarEmulator laser(test_world, options);
    expect_found(laser, rplidar::model_name(options.model) + " at " + std::to_string(options.baud));
  }
  for (const auto& options : {ydlidar::YdlidarEmulatorOptions{}, ydlidar::g4()}) {
    ydlidar::YdlidarEmulator laser(test_world, options);
    expect_found(laser, "YDLIDAR " + ydlidar::model_name(options.model) + " at " +
                            std::to_string(options.baud));
  }
  for (const bool old : {false, true}) {
    for (const int baud : {0, 19'200, 38'400, 57'600, 115'200}) {
      hokuyo::HokuyoEmulatorOptions options;
      options.baud = baud;
      options.scip1 = old;
      hokuyo::HokuyoEmulator laser(test_world, options);
      expect_found(laser, "Hokuyo URG-04LX at " + std::to_string(baud == 0 ? 115'200 : baud));
    }
  }
  for (const int baud : {9600, 19'200, 38'400, 500'000}) {
    sick::SickEmulatorOptions options;
    options.baud = baud;
    options.power_on_s = 0.0;
    sick::SickEmulator laser(test_world, options);
    const sick::Configuration before = laser.configuration();
    expect_found(laser, "SICK LMS at " + std::to_string(baud));
    EXPECT_EQ(laser.configuration(), before);
  }
}

// Which has no rates.
TEST(Devices, LasersOnTheNetworkAreFound) {
  const auto expect_on_network = [](Emulator& emulator, const std::string& beginning,
                                    const std::string& ending) {
    SimulatedLine line(emulator, false);
    const auto stream = line.open({});
    PortReport report{{"tcp:10.0.0.7:2112", {}, true}, "", "", {}, {}};
    const Utime begin = line.now();
    survey_line(
        *stream, [&line] { return line.now(); }, report, false);
    EXPECT_THAT(describe(report),
                ::testing::StartsWith(beginning + " on tcp:10.0.0.7:2112, scans"));
    EXPECT_THAT(describe(report), ::testing::EndsWith(ending));
    EXPECT_LT((line.now() - begin).seconds(), 6.0);
    return robot_files({report}, "/x", "/y", measured).at("laser.toml");
  };
  for (const auto& model : {cola::ColaEmulatorOptions{}, cola::tim551(), cola::lms111()}) {
    cola::ColaEmulator laser(test_world, model);
    const std::string file = expect_on_network(laser, "SICK " + model.model, "(marco-cola)");
    EXPECT_THAT(file, ::testing::HasSubstr("device = \"tcp:10.0.0.7:2112\""));
    EXPECT_FALSE(laser.streaming());
  }
  hokuyo::HokuyoEmulatorOptions ust;
  ust.model = "UST-10LX";
  hokuyo::HokuyoEmulator laser(test_world, ust);
  const std::string file = expect_on_network(laser, "Hokuyo UST-10LX", "(marco-hokuyo)");
  EXPECT_THAT(file, ::testing::HasSubstr("baud = 0 "));
}

TEST(Devices, BasesAndImusAreFound) {
  textbase::TextBoard text_board;
  expect_found(text_board, "base with Marco's text protocol, 'sim' at 115200");
  kobuki::KobukiEmulator turtle;
  expect_found(turtle, "Kobuki (TurtleBot 2) at 115200");
  p2os::P2osEmulator pioneer;
  expect_found(pioneer, "Pioneer base (P2OS, ARCOS) at 9600");
  hcs12::BaseEmulator base({}, {});
  expect_found(base, "base board of thesis B at 9600", 5.0);
  EXPECT_EQ(base.left_clicks(), 0.0);
  const std::string banner = "Robot ROCA-MOBILE-2 v1.0 listo\n";
  EXPECT_EQ(
      judge({reinterpret_cast<const uint8_t*>(banner.data()), banner.size()}, Kind::silence).kind,
      Kind::hcs12_base);
  hcs12::PanTiltEmulator head({});
  expect_found(head, "pan-tilt board of thesis B at 9600", 60.0);  // it seeks its home first
  bno055::Bno055Emulator bno055([](Utime) { return imu::Motion{}; });
  expect_found(bno055, "Bosch BNO055 IMU at 115200");
  for (const int baud : {9600, 115'200}) {
    imu::ImuEmulatorOptions options;
    options.baud = baud;
    imu::ImuEmulator imu([](Utime) { return imu::Motion{}; }, options);
    expect_found(imu, "WitMotion IMU at " + std::to_string(baud));
  }
}

// START changes what a Roomba does, so only who names its port has it asked.
TEST(Devices, ACreateIsAskedOnRequest) {
  for (const int baud : {115'200, 57'600, 19'200}) {
    create::CreateEmulatorOptions options;
    options.baud = baud;
    create::CreateEmulator robot(options);
    EXPECT_EQ(look_at(robot).finding.claim.kind, Kind::silence);
    EXPECT_EQ(robot.mode(), create::OiMode::off);
    create::CreateEmulator named(options);
    const PortReport report = look_at(named, true, 0.0, true);
    EXPECT_EQ(describe(report), "iRobot Create 2 or Roomba at " + std::to_string(baud) +
                                    " on /dev/ttyUSB0 (marco-create)");
    EXPECT_EQ(named.mode(), create::OiMode::passive);
  }
}

// A laser that a program left measuring talks by itself.
TEST(Devices, LasersLeftMeasuringAreFound) {
  for (const auto& [model, mode] :
       {std::pair{rplidar::RplidarEmulatorOptions{}, "express"},
        std::pair{rplidar::RplidarEmulatorOptions{}, "standard"},
        std::pair{rplidar::a3(), "express"}, std::pair{rplidar::c1(), "express"}}) {
    rplidar::RplidarEmulator laser(test_world, model);
    SimulatedLine line(laser);
    const auto stream = line.open({115'200});
    rplidar::RplidarOptions options;
    options.mode = mode;
    rplidar::RplidarDriver driver(*stream, options, [&line] { return line.now(); });
    step_until(driver, line, 5.0, have(2));
    const Finding finding = probe(
        *stream, [&line] { return line.now(); }, Manner::listen);
    EXPECT_EQ(finding.claim.kind, Kind::rplidar) << mode;
  }
}

TEST(Devices, StrangersAreNamedAndLetAlone) {
  const std::string fix = "GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,";
  unsigned sum = 0;
  for (const char c : fix) sum ^= static_cast<uint8_t>(c);
  char ending[8];
  std::snprintf(ending, sizeof(ending), "*%02X\r\n", sum);
  const std::string sentence = "$" + fix + ending;
  for (const int baud : {4800, 9600, 115'200}) {
    Stranger gps({baud, 1.0, sentence + sentence, false, ""});
    const PortReport report = look_at(gps);
    EXPECT_EQ(report.finding.claim.kind, Kind::nmea);
    EXPECT_EQ(report.finding.baud, baud);
    EXPECT_TRUE(gps.heard().empty());
  }
  for (const int baud : {9600, 57'600, 115'200}) {
    Stranger arduino({baud, 0.5, "Temperature: 23.4 C\r\n", false, ""});
    const PortReport report = look_at(arduino);
    EXPECT_EQ(describe(report), "/dev/ttyUSB0: bytes arrive at " + std::to_string(baud) +
                                    " that look like text: 'Temperature: 23.4 C'. Your own base? "
                                    "docs/text_base.md describes the protocol");
    EXPECT_TRUE(arduino.heard().empty());
  }
  Stranger prompt(
      {115'200, 2.0, "\r\nDebian GNU/Linux 12 robot ttyS0\r\n\r\nrobot login: ", true, ""});
  const PortReport waits = look_at(prompt);
  EXPECT_EQ(describe(waits),
            "/dev/ttyUSB0: a terminal at 115200 that waits for input: 'robot login: '");
  EXPECT_TRUE(prompt.heard().empty());
}

// It shows its prompt only to who presses a key. What it is sent it takes for a name.
TEST(Devices, ATerminalIsNotAskedTwice) {
  Stranger silent_prompt({115'200, 0.0, "", true, "\r\nrobot login: "});
  const PortReport report = look_at(silent_prompt);
  EXPECT_TRUE(report.finding.echoes);
  EXPECT_EQ(silent_prompt.heard(), questions().front().bytes);
  Stranger without_echo({115'200, 0.0, "", false, "\r\nrobot login: "});
  EXPECT_EQ(look_at(without_echo).finding.claim.kind, Kind::login);
}

TEST(Devices, ASilentPortIsSilent) {
  Stranger silent({});
  EXPECT_THAT(describe(look_at(silent)), ::testing::HasSubstr("answers none of Marco's queries"));
  EXPECT_FALSE(silent.heard().empty());
  Stranger unasked({});
  EXPECT_THAT(describe(look_at(unasked, false)),
              ::testing::HasSubstr("no query was sent, because it is a test. `marco devices"));
  EXPECT_TRUE(unasked.heard().empty());
}

// The protocol of thesis B's boards has no checksum: only who was asked is believed.
TEST(Devices, NoiseIsNobody) {
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    Bytes noise(1 + random() % 16'384);
    const unsigned mask = round % 3 == 0 ? 0x7F : 0xFF;
    for (uint8_t& byte : noise) byte = static_cast<uint8_t>(random() & mask);
    for (const Kind asked : {Kind::silence, Kind::rplidar, Kind::ydlidar, Kind::hokuyo}) {
      const Claim claim = judge(noise, asked);
      EXPECT_LE(claim.kind, Kind::text) << claim.name;
    }
  }
}

// A5 and a command of Slamtec's or YDLIDAR's family press a started Roomba's buttons; see
// questions.hpp for the others.
TEST(Devices, QuestionsChangeNothing) {
  std::vector<Question> all = questions();
  all.insert(all.end(), network_questions().begin(), network_questions().end());
  for (const Question& question : all) {
    const Bytes& bytes = question.bytes;
    for (std::size_t i = 0; i + 1 < bytes.size(); ++i) {
      if (bytes[i] != 0xA5) continue;
      EXPECT_TRUE(bytes[i + 1] == 0x50 || bytes[i + 1] == 0x90);
    }
    if (question.on_request) continue;
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_EQ(text.find_first_of("$!~GM+"), std::string::npos) << text;
    EXPECT_EQ(text.find("\x55\x55"), std::string::npos);
  }
}

TEST(Devices, SentencesNeedTheirSum) {
  EXPECT_TRUE(
      is_nmea_sentence("$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76"));
  EXPECT_FALSE(
      is_nmea_sentence("$GPGGA,092751.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,*76"));
  EXPECT_FALSE(is_nmea_sentence("$*00"));
  EXPECT_FALSE(is_nmea_sentence(""));
}

class FakeMachine : public ::testing::Test {
 protected:
  FakeMachine() { std::filesystem::create_directories(folder_); }
  ~FakeMachine() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("marco_devices_" + std::to_string(::getpid()));
};

// As the kernel lays it out: the class's entry leads to a folder some levels below the USB
// device's.
TEST_F(FakeMachine, PortsAreKnownByTheirUsbIdentity) {
  namespace fs = std::filesystem;
  const fs::path device = folder_ / "sys/devices/usb1/1-2";
  const fs::path port = device / "1-2:1.0/ttyUSB0";
  fs::create_directories(port / "tty/ttyUSB0");
  for (const auto& [name, text] :
       {std::pair{"idVendor", "10c4"}, {"idProduct", "ea60"}, {"product", "CP2102 Bridge"}}) {
    std::ofstream(device / name) << text << "\n";
  }
  fs::create_directories(folder_ / "class");
  fs::create_directory_symlink(port / "tty/ttyUSB0", folder_ / "class/ttyUSB0");
  fs::create_directory_symlink(port, port / "tty/ttyUSB0/device");
  fs::create_directories(folder_ / "dev/serial/by-id");
  std::ofstream(folder_ / "dev/ttyUSB0") << "";
  fs::create_symlink("../../ttyUSB0", folder_ / "dev/serial/by-id/usb-CP2102-if00-port0");
  const auto ports = ports_here((folder_ / "dev").string(), (folder_ / "class").string());
  ASSERT_EQ(ports.size(), 1u);
  EXPECT_TRUE(ports[0].path.ends_with("by-id/usb-CP2102-if00-port0"));
  EXPECT_EQ(describe(ports[0].identity), "USB 10c4:ea60, CP2102 Bridge");
  EXPECT_EQ(why_not_asked(ports[0].identity), "");
}

TEST(Devices, ModemsReceiversAndPortsOfTheBoardAreNotAsked) {
  EXPECT_NE(why_not_asked({"1546:01a8", "", "", ""}), "");
  EXPECT_NE(why_not_asked({"12d1:1001", "", "", ""}), "");
  EXPECT_NE(why_not_asked({"", "", "", ""}), "");
  EXPECT_NE(why_not_asked({"dead:beef", "", "", ""}), "");
  EXPECT_EQ(why_not_asked({"1a86:7523", "", "", ""}), "");
}

PortReport found(Kind kind, const std::string& path) {
  PortReport report;
  report.port.path = path;
  report.finding = {{kind, "a device"}, 115'200, 0.0, false};
  return report;
}

TEST(Devices, RobotFilesHoldEachDeviceOnce) {
  const auto files =
      robot_files({found(Kind::rplidar, "/dev/a"), found(Kind::nmea, "/dev/b"),
                   found(Kind::sick, "/dev/c"), found(Kind::p2os, "/dev/d")},
                  "/home/me/my robot", "/opt/marco/config/mapping.procman", measured);
  std::set<std::string> names;
  for (const auto& [name, text] : files) names.insert(name);
  EXPECT_EQ(names,
            (std::set<std::string>{"robot.procman", "laser.toml", "laser_2.toml", "base.toml"}));
  EXPECT_THAT(files.at("laser.toml"), ::testing::HasSubstr("channel = \"LIDAR_1\""));
  EXPECT_THAT(files.at("robot.procman"),
              ::testing::HasSubstr("marco-sick --config '/home/me/my robot/laser_2.toml'"));
  EXPECT_TRUE(robot_files({found(Kind::text, "/dev/b")}, "/x", "/y", measured).empty());
  EXPECT_THROW(robot_files({found(Kind::sick, "/dev/\"")}, "/x", "/y", measured),
               std::invalid_argument);
}

TEST(Devices, ALasersHeightIsNotInvented) {
  const auto laser_with = [](const LaserHeight& height_m) {
    return robot_files({found(Kind::rplidar, "/dev/a")}, "/x", "/y", height_m).at("laser.toml");
  };
  EXPECT_THAT(laser_with(measured), ::testing::HasSubstr("\nposition_m = [0.0, 0.0, 0.18]\n"));
  const std::string unknown = laser_with([](const std::string& laser) {
    EXPECT_EQ(laser, "laser");
    return std::optional<double>();
  });
  EXPECT_THAT(unknown, ::testing::HasSubstr("\n# position_m = "));
  EXPECT_THAT(unknown, ::testing::HasSubstr("until it is given, the base drives at most 0.2 m/s"));
  EXPECT_THAT(unknown, ::testing::Not(::testing::HasSubstr("\nposition_m")));
}

}  // namespace
}  // namespace marco::drivers::devices
