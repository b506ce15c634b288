#include "drivers/devices/survey.hpp"

#include <signal.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "drivers/cola/driver.hpp"
#include "drivers/devices/questions.hpp"
#include "drivers/hokuyo/driver.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "drivers/leuze/driver.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/transport/port_advice.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "drivers/ydlidar/driver.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::devices {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

struct Maker {
  std::string_view id;  ///< of its maker, or of one product
  std::string_view what;
};

// Bridges that lasers and bases are sold with, boards of home-made bases, Hokuyo's own.
constexpr std::array kAsked{
    std::string_view("10c4:ea60"), std::string_view("0403:"),     std::string_view("067b:"),
    std::string_view("1a86:"),     std::string_view("0483:5740"), std::string_view("15d1:"),
    std::string_view("2341:"),     std::string_view("2a03:"),     std::string_view("303a:"),
    std::string_view("2e8a:"),     std::string_view("16c0:")};
constexpr std::array kLeftAlone{Maker{"1546:", "a u-blox satellite receiver"},
                                Maker{"091e:", "a Garmin satellite receiver"},
                                Maker{"12d1:", "a modem"},
                                Maker{"1199:", "a modem"},
                                Maker{"2c7c:", "a modem"},
                                Maker{"1bc7:", "a modem"},
                                Maker{"19d2:", "a modem"},
                                Maker{"1e0e:", "a modem"}};

constexpr double kPatienceS = 10.0;
constexpr int kHokuyoBaud = 115'200;  // its fastest on RS-232
constexpr int kScans = 5;             // the first is not whole, or late

std::unique_ptr<LaserDriver> driver_of(Kind laser,
                                       int baud,
                                       ByteStream& stream,
                                       const Clock& clock) {
  if (laser == Kind::ldlidar) {
    return std::make_unique<ldlidar::LdlidarDriver>(stream, ldlidar::LdlidarOptions{}, clock);
  }
  if (laser == Kind::ydlidar) {
    return std::make_unique<ydlidar::YdlidarDriver>(stream, ydlidar::YdlidarOptions{}, clock);
  }
  if (laser == Kind::rplidar) {
    rplidar::RplidarOptions options;
    options.baud = baud;
    return std::make_unique<rplidar::RplidarDriver>(stream, options, clock);
  }
  if (laser == Kind::hokuyo) {
    hokuyo::HokuyoOptions options;
    // One on USB understands at any rate, and knows none. TCP has none.
    options.baud = baud == kHokuyoBaud || baud == 0 ? 0 : kHokuyoBaud;
    return std::make_unique<hokuyo::HokuyoDriver>(stream, options, clock);
  }
  if (laser == Kind::cola) {
    return std::make_unique<cola::ColaDriver>(stream, cola::ColaOptions{}, clock);
  }
  leuze::LeuzeOptions options;
  options.baud = baud;
  return std::make_unique<leuze::LeuzeDriver>(stream, options, clock);
}

// Lets the driver run until some scans came, ten seconds at most, then stops the laser. Throws
// StreamLost.
LaserTrial try_laser(ByteStream& stream, const Clock& clock, Kind laser, int baud) {
  if (!may_be_tried(laser)) throw std::logic_error("no trial for this laser");
  const auto driver = driver_of(laser, baud, stream, clock);
  LaserTrial trial;
  const Utime begin = clock();
  Utime first, last;
  int scans = 0;
  while (scans < kScans && (clock() - begin).seconds() < kPatienceS) {
    for (const ArrivedScan& arrived : driver->step()) {
      if (++scans == 1) first = arrived.scan.utime;
      last = arrived.scan.utime;
      trial.beams = arrived.scan.size();
    }
  }
  if (scans > 1 && last > first) trial.scans_per_s = (scans - 1) / (last - first).seconds();
  trial.state = driver->state();
  driver->stop();
  return trial;
}

/// Modem programs leave a file with their process number instead of a kernel's lock.
std::string holder_by_lock_file(const std::string& path) {
  std::error_code error;
  const std::string name = fs::weakly_canonical(path, error).filename().string();
  for (const char* folder : {"/run/lock", "/var/lock"}) {
    std::ifstream file(fs::path(folder) / ("LCK.." + name));
    int pid = 0;
    if (file >> pid && pid > 0 && (kill(pid, 0) == 0 || errno == EPERM)) {
      return "process " + std::to_string(pid);
    }
  }
  return {};
}

std::string text_of(double value, int decimals) { return format("%.*f", decimals, value); }

/// Of a device on TCP: nothing.
std::string at_baud(int baud) { return baud > 0 ? " at " + std::to_string(baud) : ""; }

std::string device_text(const PortReport& report) {
  const Finding& finding = report.finding;
  std::string text = finding.claim.name + at_baud(finding.baud) + " on " + report.port.path;
  if (report.trial && report.trial->scans_per_s > 0.0) {
    text += ", scans at " + text_of(report.trial->scans_per_s, 1) + " Hz, " +
            std::to_string(report.trial->beams) + " beams";
  } else if (report.trial) {
    text += ", but no scans come: " + report.trial->state;
  }
  return text + " (" + program_of(finding.claim.kind) + ")";
}

std::string silence_text(const PortReport& report) {
  if (report.finding.echoes) {
    return "echoes what it receives: a terminal, a modem, or a wire from TX to RX; nothing more "
           "was asked";
  }
  if (report.unasked.empty()) {
    const char* create = report.port.named ? ""
                                           : " A Create or Roomba answers only if you name the "
                                             "port.";
    return std::string(
               "silent, and answers none of Marco's queries: is the device powered, and one that "
               "Marco knows?") +
           create;
  }
  return "silent; no query was sent, because " + report.unasked;
}

std::string stranger_text(const PortReport& report) {
  const Finding& finding = report.finding;
  const std::string arrive = "bytes arrive" + at_baud(finding.baud) + " that look like ";
  switch (finding.claim.kind) {
    case Kind::nmea:
      return arrive + "NMEA sentences, as satellite receivers send: " + finding.claim.name;
    case Kind::text:
      return arrive + "text: '" + finding.claim.name +
             "'. Your own base? docs/text_base.md describes the protocol";
    case Kind::login:
      return "a terminal" + at_baud(finding.baud) + " that waits for input: '" +
             finding.claim.name + "'";
    case Kind::bytes:
      return text_of(finding.bytes_per_s, 0) +
             " bytes a second arrive that fit no baud rate: neither text nor a device that "
             "Marco knows";
    default:
      return silence_text(report);
  }
}

}  // namespace

PortIdentity identify_port(const std::string& path, const std::string& classes) {
  std::error_code error;
  const fs::path port = fs::weakly_canonical(path, error);
  fs::path folder = fs::canonical(fs::path(classes) / port.filename() / "device", error);
  if (error) return {};
  for (; folder.has_relative_path(); folder = folder.parent_path()) {
    if (!fs::exists(folder / "idVendor", error)) continue;
    return {first_line(folder / "idVendor") + ":" + first_line(folder / "idProduct"),
            first_line(folder / "manufacturer"), first_line(folder / "product"),
            first_line(folder / "serial")};
  }
  return {};
}

std::string describe(const PortIdentity& identity) {
  if (identity.usb_id.empty()) return {};
  std::string text = "USB " + identity.usb_id;
  if (!identity.product.empty()) text += ", " + identity.product;
  return text;
}

std::string why_not_asked(const PortIdentity& identity) {
  if (identity.usb_id.empty()) return "it is not on USB, so any device may be there";
  const auto begins = [&identity](std::string_view id) { return identity.usb_id.starts_with(id); };
  for (const Maker& maker : kLeftAlone) {
    if (begins(maker.id)) return "USB " + identity.usb_id + " is " + std::string(maker.what);
  }
  if (std::any_of(kAsked.begin(), kAsked.end(), begins)) return {};
  return "USB " + identity.usb_id + " is unknown to Marco";
}

bool may_be_tried(Kind laser) { return is_laser(laser) && laser != Kind::sick; }

std::vector<Port> ports_here(const std::string& folder, const std::string& classes) {
  std::vector<Port> ports;
  for (const DeviceSeen& seen : devices_seen(DeviceKind::serial, folder)) {
    const std::string& path = seen.by_id.empty() ? seen.path : seen.by_id;
    ports.push_back({path, identify_port(seen.path, classes), false});
  }
  return ports;
}

void survey_line(ByteStream& stream, const Clock& clock, PortReport& report, bool listen_only) {
  const bool ask = !listen_only && report.unasked.empty();
  Finding& finding = report.finding;
  const Manner asking = report.port.named ? Manner::ask_all : Manner::ask;
  const Reach reach = report.port.path.starts_with("tcp:") ? Reach::network : Reach::serial;
  finding = probe(stream, clock, ask ? asking : Manner::listen, reach);
  if (listen_only || !may_be_tried(finding.claim.kind)) return;
  report.trial = try_laser(stream, clock, finding.claim.kind, finding.baud);
}

PortReport survey(const Port& port, bool listen_only) {
  PortReport report{port, "", "", {}, {}};
  if (!port.named) report.unasked = why_not_asked(port.identity);
  if (listen_only) report.unasked = "you asked to listen only";
  std::string holder = holder_of(port.path);
  if (holder.empty()) holder = holder_by_lock_file(port.path);
  if (!holder.empty()) {
    report.trouble = "held by " + holder + "; not touched";
    return report;
  }
  try {
    const auto stream = open_stream(port.path, {rates().front(), Parity::none});
    survey_line(*stream, wall_now, report, listen_only);
  } catch (const std::exception& failure) {
    // It begins with the path.
    const std::string what = failure.what();
    report.trouble = what.starts_with(port.path + ": ") ? what.substr(port.path.size() + 2) : what;
  }
  return report;
}

std::string describe(const PortReport& report) {
  if (!report.trouble.empty()) return report.port.path + ": " + report.trouble;
  if (is_device(report.finding.claim.kind)) return device_text(report);
  std::string text = report.port.path + ": " + stranger_text(report);
  const bool may_be_named = !report.unasked.empty() && !report.port.named;
  if (may_be_named && report.finding.claim.kind == Kind::silence) {
    text += ". `marco devices " + report.port.path + "` asks";
  }
  return text;
}

std::string program_of(Kind kind) {
  static const std::map<Kind, const char*> kPrograms{{Kind::ldlidar, "marco-ldlidar"},
                                                     {Kind::ydlidar, "marco-ydlidar"},
                                                     {Kind::rplidar, "marco-rplidar"},
                                                     {Kind::sick, "marco-sick"},
                                                     {Kind::hokuyo, "marco-hokuyo"},
                                                     {Kind::leuze, "marco-leuze"},
                                                     {Kind::cola, "marco-cola"},
                                                     {Kind::bno055, "marco-bno055"},
                                                     {Kind::imu, "marco-imu"},
                                                     {Kind::p2os, "marco-p2os"},
                                                     {Kind::textbase, "marco-textbase"},
                                                     {Kind::create, "marco-create"},
                                                     {Kind::kobuki, "marco-kobuki"},
                                                     {Kind::hcs12_base, "marco-base"},
                                                     {Kind::hcs12_pantilt, "marco-pantilt"}};
  const auto program = kPrograms.find(kind);
  return program == kPrograms.end() ? "" : program->second;
}

}  // namespace marco::drivers::devices
