#include <gmock/gmock.h>

#include <fcntl.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>
#include <thread>

#include "drivers/transport/clock_filter.hpp"
#include "drivers/transport/paced_output.hpp"
#include "drivers/transport/turn_counter.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "simulator/devices/transport/emulator_port.hpp"
#include "simulator/devices/transport/simulated_line.hpp"

namespace marco::drivers {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

// Sends back each byte plus one, at its own speed, when the client's line has that speed.
class NextByte final : public Emulator {
 public:
  explicit NextByte(int baud) : output_(baud) {}
  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override {
    last_baud = baud;
    if (baud != output_.baud()) return;
    Bytes answer;
    for (const uint8_t byte : bytes) answer.push_back(static_cast<uint8_t>(byte + 1));
    output_.send(answer, now);
  }
  void advance(Utime now, Bytes& out) override { output_.advance(now, out); }
  Utime next_event() const override { return output_.next_event(); }
  void on_connection(bool is_connected, Utime) override {
    connected = is_connected;
    connections += is_connected ? 1 : 0;
  }
  int last_baud = -1;
  bool connected = false;
  int connections = 0;

 private:
  PacedOutput output_;
};

// Serves the port while the client reads, in one thread, so that the order is the same each time.
Bytes read_all(ByteStream& stream, EmulatorPort& port, std::size_t count) {
  Bytes got;
  std::array<EmulatorPort*, 1> ports{&port};
  const Utime limit = wall_now() + Duration::from_us(800'000);
  while (got.size() < count && wall_now() < limit) {
    serve_ports(ports, Duration::from_us(1000));
    uint8_t buffer[64];
    const std::size_t some = stream.read(buffer, 0us);
    got.insert(got.end(), buffer, buffer + some);
  }
  return got;
}

template <class Condition>
bool serve_until(EmulatorPort& port, Condition condition) {
  std::array<EmulatorPort*, 1> ports{&port};
  const Utime limit = wall_now() + Duration::from_us(800'000);
  while (!condition() && wall_now() < limit) serve_ports(ports, Duration::from_us(1000));
  return condition();
}

std::string link_name(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("marco_" + std::to_string(getpid()) + name))
      .string();
}

TEST(EmulatorPort, SpeaksThroughATerminalAtAnySpeed) {
  for (const int baud : {9600, 38400, 500'000, 123'456}) {
    NextByte device(baud);
    EmulatorPort port = EmulatorPort::pty(device);
    const auto stream = open_stream("serial:" + port.address(), {baud});
    stream->write(Bytes{1, 0x0A, 0x0D, 0x11, 0x13, 0xFF, 3});
    EXPECT_THAT(read_all(*stream, port, 7), ElementsAre(2, 0x0B, 0x0E, 0x12, 0x14, 0, 4));
    EXPECT_EQ(device.last_baud, baud);
  }
}

TEST(EmulatorPort, TellsTheDeviceThatItsClientHasAnotherSpeed) {
  NextByte device(38400);
  EmulatorPort port = EmulatorPort::pty(device);
  const auto stream = open_stream(port.address(), {9600});
  stream->write(Bytes{1});
  EXPECT_TRUE(serve_until(port, [&] { return device.last_baud == 9600; }));
  stream->set_line({38400});
  EXPECT_TRUE(serve_until(port, [&] { return device.last_baud == 38400; }));
  stream->write(Bytes{7});
  EXPECT_THAT(read_all(*stream, port, 1), ElementsAre(8));
}

TEST(EmulatorPort, KeepsItsNameAndTellsComingAndGoing) {
  NextByte device(9600);
  const std::string link = link_name("_plug");
  EmulatorPort port = EmulatorPort::pty(device, link);
  {
    const auto stream = open_stream(link, {9600});
    EXPECT_TRUE(serve_until(port, [&] { return device.connected; }));
  }
  EXPECT_TRUE(serve_until(port, [&] { return !device.connected; }));
  const auto stream = open_stream(link, {9600});
  EXPECT_TRUE(serve_until(port, [&] { return device.connected; }));
  port.unplug();
  uint8_t buffer[8];
  EXPECT_THROW(stream->read(buffer, 100ms), StreamLost);
  EXPECT_THROW(open_stream(link, {9600}), StreamLost);
  port.plug_in();
  const auto again = open_stream(link, {9600});
  again->write(Bytes{4});
  EXPECT_THAT(read_all(*again, port, 1), ElementsAre(5));
  EXPECT_EQ(device.connections, 3);
}

TEST(EmulatorPort, SpeaksThroughTcpToOneClientAfterTheOther) {
  NextByte device(0);
  EmulatorPort port = EmulatorPort::tcp(device, 0);
  for (int client = 0; client < 3; ++client) {
    const auto stream = open_stream(port.address(), {9600});
    stream->write(Bytes{1, 2});
    EXPECT_THAT(read_all(*stream, port, 2), ElementsAre(2, 3));
  }
  EXPECT_EQ(device.connections, 3);
  const auto last = open_stream(port.address(), {9600});
  EXPECT_TRUE(serve_until(port, [&] { return device.connections == 4; }));
  port.unplug();
  uint8_t buffer[8];
  EXPECT_THROW(last->read(buffer, 100ms), StreamLost);
  EXPECT_THROW(open_stream(port.address(), {9600}), StreamLost);
}

// A client that does not read for a while loses nothing of what a real line's buffer holds, and
// what it gets then is what came first.
TEST(EmulatorPort, KeepsALinesBufferForASlowClient) {
  constexpr std::size_t kLine = 65536, kChunk = 3000, kChunks = 40;
  class Flood final : public Emulator {
   public:
    void receive(std::span<const uint8_t>, int, Utime) override {}
    void advance(Utime, Bytes& out) override {
      for (std::size_t i = 0; connected && chunks < kChunks && i < kChunk; ++i, ++sent) {
        out.push_back(static_cast<uint8_t>(sent % 251));
      }
      chunks += connected ? 1 : 0;
    }
    Utime next_event() const override { return Utime{}; }
    void on_connection(bool is_connected, Utime) override { connected = is_connected; }
    bool connected = false;
    std::size_t chunks = 0, sent = 0;
  } device;
  EmulatorPort port = EmulatorPort::pty(device);
  const auto stream = open_stream(port.address(), {115'200});
  ASSERT_TRUE(serve_until(port, [&] { return device.chunks >= kChunks; }));
  const Bytes got = read_all(*stream, port, kLine);
  ASSERT_GE(got.size(), kLine);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < kLine; ++i) wrong += got[i] == i % 251 ? 0 : 1;
  EXPECT_EQ(wrong, 0u);
  EXPECT_LT(read_all(*stream, port, kChunk * kChunks).size() + got.size(), kChunk * kChunks);
}

// An order must not arrive late.
TEST(OpenStream, WhatALineDoesNotTakeInTimeIsDiscarded) {
  const FileHandle device(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  grantpt(device.get());
  unlockpt(device.get());
  const std::string name = ptsname(device.get());
  set_terminal(FileHandle(open(name.c_str(), O_RDWR | O_NOCTTY)).get(), {});
  const auto stream = open_stream(name, {9600});
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(stream->write(Bytes(100'000, 'o')), StreamLost);
  EXPECT_GT(std::chrono::steady_clock::now() - begin, 300ms);
  std::size_t waited = 0;
  uint8_t bytes[4096];
  for (ssize_t size = 0; (size = read(device.get(), bytes, sizeof bytes)) > 0;) {
    waited += static_cast<std::size_t>(size);
  }
  EXPECT_LE(waited, 4096U);  // what had left it
  EXPECT_NO_THROW(stream->write(Bytes{'n'}));
}

TEST(OpenStream, RefusesASecondDriverAndNonsense) {
  NextByte device(9600);
  EmulatorPort port = EmulatorPort::pty(device);
  auto first = open_stream(port.address(), {9600});
  EXPECT_THROW(open_stream(port.address(), {9600}), std::invalid_argument);
  first.reset();
  EXPECT_NO_THROW(open_stream(port.address(), {9600}));
  EXPECT_THROW(open_stream("", {9600}), std::invalid_argument);
  EXPECT_THROW(open_stream("tcp:nowhere", {9600}), std::invalid_argument);
  EXPECT_THROW(open_stream("/dev/null", {9600}), std::invalid_argument);
  EXPECT_THROW(open_stream("/dev/no such port", {9600}), StreamLost);
}

/// A terminal as a person has it: keys make signals, the line is echoed.
struct SomebodysTerminal {
  SomebodysTerminal() : master(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK)) {
    grantpt(master.get());
    unlockpt(master.get());
    char text[128];
    name = ptsname_r(master.get(), text, sizeof(text)) == 0 ? text : "";
    slave.reset(::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    tcgetattr(slave.get(), &before);
  }
  /// Nothing was written to its screen and its settings are as they were.
  void expect_untouched() const {
    termios after{};
    ASSERT_EQ(tcgetattr(slave.get(), &after), 0);
    EXPECT_EQ(after.c_lflag, before.c_lflag);
    EXPECT_EQ(after.c_iflag, before.c_iflag);
    EXPECT_EQ(after.c_oflag, before.c_oflag);
    EXPECT_EQ(after.c_cflag, before.c_cflag);
    char screen[64];
    EXPECT_EQ(read(master.get(), screen, sizeof(screen)), -1);
  }
  FileHandle master, slave;
  std::string name;
  termios before{};
};

void expect_refused(const std::string& path, const std::string& why) {
  try {
    open_stream(path, {9600})->write(Bytes{0x02, 0x20});
    ADD_FAILURE() << path << " was opened";
  } catch (const StreamLost& refusal) {
    EXPECT_THAT(refusal.what(), ::testing::HasSubstr(why));
  }
}

TEST(OpenStream, TakesNobodysTerminal) {
  const SomebodysTerminal terminal;
  ASSERT_NE(terminal.name, "");
  expect_refused(terminal.name, "a user's terminal");
  const std::string link = link_name("_by_hand");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(terminal.name, link);
  expect_refused(link, "a user's terminal");
  std::filesystem::remove(link);
  terminal.expect_untouched();
}

// kill -9 leaves the simulator's links, and the next terminal that is opened gets their number; it
// may be raw at that moment, as an editor sets it.
TEST(OpenStream, TakesNoTerminalThatADeadSimulatorsLinkLeadsTo) {
  const std::string link = link_name("_killed");
  const pid_t simulator = fork();
  if (simulator == 0) {
    NextByte device(9600);
    EmulatorPort* port = new EmulatorPort(EmulatorPort::pty(device, link));
    _exit(port->address() == link ? 0 : 1);  // without its destructor
  }
  int status = 1;
  ASSERT_EQ(waitpid(simulator, &status, 0), simulator);
  ASSERT_EQ(status, 0);
  ASSERT_TRUE(std::filesystem::is_symlink(link));
  for (const bool raw : {false, true}) {
    SomebodysTerminal terminal;
    if (raw) cfmakeraw(&terminal.before);
    tcsetattr(terminal.slave.get(), TCSANOW, &terminal.before);
    // Most often it has the number that the link says; made so here.
    std::filesystem::remove(link);
    std::filesystem::create_symlink(terminal.name, link);
    expect_refused(link, "the simulator that made this link has ended");
    terminal.expect_untouched();
  }
  // The simulator started again takes its links up.
  NextByte device(9600);
  EmulatorPort port = EmulatorPort::pty(device, link);
  const auto stream = open_stream(link, {9600});
  stream->write(Bytes{4});
  EXPECT_THAT(read_all(*stream, port, 1), ElementsAre(5));
}

TEST(EmulatorPort, TwoSimulatorsDoNotShareALink) {
  const std::string link = link_name("_two");
  NextByte device(9600);
  {
    EmulatorPort port = EmulatorPort::pty(device, link);
    EXPECT_THROW(EmulatorPort::pty(device, link), std::runtime_error);
    const auto stream = open_stream(link, {9600});  // the first one's still
    stream->write(Bytes{4});
    EXPECT_THAT(read_all(*stream, port, 1), ElementsAre(5));
  }
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(link)));
  EXPECT_NO_THROW(EmulatorPort::pty(device, link));
}

TEST(PacedOutput, LetsBytesOutAtTheSpeedOfTheLine) {
  PacedOutput output(10'000);  // one byte a millisecond
  const Utime start = Utime::from_us(1'000'000);
  output.send(Bytes{1, 2, 3, 4, 5}, start);
  output.send(Bytes{6}, start + Duration::from_us(2000));
  Bytes out;
  output.advance(start + Duration::from_us(999), out);
  EXPECT_TRUE(out.empty());
  output.advance(start + Duration::from_us(2000), out);
  EXPECT_THAT(out, ElementsAre(1, 2));
  EXPECT_EQ(output.next_event(), start + Duration::from_us(4000));
  output.advance(start + Duration::from_us(5000), out);
  EXPECT_THAT(out, ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(output.next_event(), start + Duration::from_us(6000));
  output.advance(output.next_event(), out);
  EXPECT_EQ(out.size(), 6u);
  EXPECT_EQ(output.next_event(), kFarFuture);
}

TEST(SimulatedLine, PassesTimeOnlyWhileTheClientReads) {
  NextByte device(10'000);
  SimulatedLine line(device);
  const Utime start = line.now();
  auto stream = line.open({10'000});
  uint8_t buffer[8];
  EXPECT_EQ(stream->read(buffer, 50ms), 0u);
  EXPECT_EQ((line.now() - start).us, 50'000);
  stream->write(Bytes{1});
  EXPECT_EQ(stream->read(buffer, 50ms), 1u);
  EXPECT_EQ((line.now() - start).us, 51'000);
  line.at(line.now() + Duration::from_us(5000), [&] { line.unplug(); });
  EXPECT_THROW(stream->read(buffer, 50ms), StreamLost);
  EXPECT_EQ((line.now() - start).us, 56'000);
  EXPECT_THROW(line.open({10'000}), StreamLost);
}

// A device clock 0.3 % fast; arrivals late by 2 ms and by jitter of 0..5 ms, rarely 40 ms. The
// lower line touches the smallest of 400 delays (expected 0.0125 ms apart from 0 each); its slope
// is that of one edge of the hull, so that at the end of the window it errs by a few times that.
TEST(ClockFilter, FindsDriftAndRemovesJitter) {
  ClockFilter filter;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter_s(0.0, 0.005);
  double worst_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double true_s = 0.0267 * i;
    const double late_s = 0.002 + jitter_s(random) + (i % 97 == 50 ? 0.04 : 0.0);
    const Utime arrival = Utime::from_seconds(1000.0 + true_s + late_s);
    const Utime found = filter.update(true_s * 1.003, arrival);
    EXPECT_LE(found, arrival);
    if (i > 400) worst_s = std::max(worst_s, std::abs(found.seconds() - 1000.002 - true_s));
  }
  EXPECT_LT(worst_s, 0.0008);
  EXPECT_NEAR(filter.drift(), 0.003, 0.0006);
  EXPECT_GT(filter.jitter_s(), 0.001);
}

// A clock is off by a thousandth. A line that becomes slower and slower, or faster, looks like a
// clock that is off by far more: the drift stays within its bound.
TEST(ClockFilter, BoundsTheDrift) {
  for (const double rate : {1.05, 0.95}) {  // device seconds per host second
    ClockFilter filter(0.01);
    double last_delay_s = 0.0;
    for (int i = 0; i < 300; ++i) {
      const double true_s = 0.0267 * i;
      const Utime arrival = Utime::from_seconds(1000.0 + true_s);
      last_delay_s = (arrival - filter.update(true_s * rate, arrival)).seconds();
    }
    const double slope = rate > 1.0 ? 0.99 : 1.01;  // host seconds per device second
    EXPECT_NEAR(filter.drift(), 1.0 / slope - 1.0, 1e-9);
    // Arrivals below the bounded line pull it down; those above are taken for delayed: by what
    // 8 s of the line's slowing exceed the bound.
    const double span_s = 0.0267 * 299;
    EXPECT_NEAR(last_delay_s, rate > 1.0 ? 0.0 : span_s * (1.0 - 1.01 * rate), 1e-5);
  }
}

TEST(ClockFilter, RefusesAClockThatGoesBack) {
  ClockFilter filter;
  filter.update(2.0, Utime::from_seconds(10.0));
  EXPECT_THROW(filter.update(1.9, Utime::from_seconds(11.0)), std::invalid_argument);
}

TEST(TurnCounter, CountsTheTurnsLeftOut) {
  TurnCounter turns(0.04);
  EXPECT_DOUBLE_EQ(turns.update(Utime::from_seconds(10.0)), 0.0);
  EXPECT_DOUBLE_EQ(turns.update(Utime::from_seconds(10.041)), 0.04);
  EXPECT_DOUBLE_EQ(turns.update(Utime::from_seconds(10.159)), 0.16);
  // The third came late, together with the fourth.
  EXPECT_DOUBLE_EQ(turns.update(Utime::from_seconds(10.165)), 0.16);
  EXPECT_DOUBLE_EQ(turns.update(Utime::from_seconds(10.2)), 0.20);
}

// Scans of a laser of 25 turns a second, as they come late.
struct LateScans {
  double turn_s;  ///< by the host's clock
  double step;    ///< turns from scan to scan
  TurnCounter turns{0.04};
  double turn = 0.0;

  /// @returns which turn the next scan is taken for.
  int64_t arrives(double late_s) {
    const Utime end = Utime::from_seconds(10.0 + turn_s * turn + late_s);
    turn += step;
    return std::llround(turns.update(end, TurnCounter::Gap::none) / 0.04);
  }
};

// Of a laser that sends every turn; one that runs 1 % slow, so that lateness of its own adds up.
TEST(TurnCounter, TellsABusyHostFromMissedTurns) {
  LateScans scans{0.0404, 1.0};
  const auto arrives = [&](double late_s) { return scans.arrives(late_s); };
  for (int i = 0; i < 200; ++i) ASSERT_EQ(arrives(0.002 * (i % 3)), i) << "jitter is no turn";
  EXPECT_EQ(arrives(0.150), 200) << "a busy host";
  EXPECT_EQ(arrives(0.112), 201);
  EXPECT_EQ(arrives(0.074), 202);
  EXPECT_EQ(arrives(0.036), 203);
  for (int i = 204; i < 300; ++i) ASSERT_EQ(arrives(0.0), i);
  scans.turn += 3.0;
  EXPECT_EQ(arrives(0.0), 300) << "nobody can tell yet";
  EXPECT_EQ(arrives(0.0), 304) << "three turns were missed";
  EXPECT_EQ(arrives(0.0), 305);
  scans.turn += 60.0;
  EXPECT_EQ(arrives(0.0), 367) << "after two seconds of silence the clock tells (61 * 1.01)";
}

// A laser whose line has time for every eighth turn only.
TEST(TurnCounter, LearnsHowManyTurnsASlowLineLeavesOut) {
  LateScans scans{0.04, 8.0};
  const auto arrives = [&](double late_s) { return scans.arrives(late_s); };
  for (int i = 0; i < 20; ++i) ASSERT_EQ(arrives(0.0), 8 * i);
  EXPECT_EQ(arrives(0.5), 160) << "a busy host";
  EXPECT_EQ(arrives(0.5 - 0.03), 168) << "the next had waited, and came as fast as the line goes";
  EXPECT_EQ(arrives(0.18), 176);
  EXPECT_EQ(arrives(0.0), 184);
  scans.turn += 1.0;
  arrives(0.0);
  for (int i = 25; i < 40; ++i) ASSERT_EQ(arrives(0.0), 8 * i + 1) << "nine, once";
}

}  // namespace
}  // namespace marco::drivers
