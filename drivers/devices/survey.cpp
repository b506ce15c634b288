#include "drivers/devices/survey.hpp"

#include <signal.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>

#include "drivers/devices/questions.hpp"
#include "drivers/transport/port_advice.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::devices {
namespace {

namespace fs = std::filesystem;

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

std::string text_of(double value, int decimals) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

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
