#include "simulator/devices/hokuyo/emulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::hokuyo {
namespace {

constexpr std::size_t kMaxRequestLine = 64;
constexpr int kLastStep = 768;
constexpr long kLargestMm = 4095;
constexpr std::array kBauds{19'200, 57'600, 115'200};

// The nearest of the merged steps; 0 where the laser does not look.
uint32_t nearest_mm(const std::vector<double>& ranges_m, int from, int to, int range_min_mm) {
  uint32_t least = 0;
  for (int i = std::max(0, from); i < std::min(to, static_cast<int>(ranges_m.size())); ++i) {
    const double range_m = ranges_m[static_cast<std::size_t>(i)];
    if (!std::isfinite(range_m)) continue;
    const long mm = std::lround(range_m * 1000.0);
    if (mm < range_min_mm || mm > kLargestMm) continue;
    least = least == 0 ? static_cast<uint32_t>(mm) : std::min(least, static_cast<uint32_t>(mm));
  }
  return least;
}

std::string scan_lines(
    const HokuyoMirror& mirror, int first_step, int last_step, int cluster, Utime now) {
  const Parameters& parameters = mirror.parameters();
  const int seen_first = std::max(first_step, parameters.first_step);
  const int seen_last = std::min(last_step, parameters.last_step);
  const std::vector<double> ranges_m =
      mirror.ranges_m(seen_first, seen_last, mirror.turn_after(now));
  std::string values;
  for (int step = first_step; step <= last_step; step += cluster) {
    const int end = std::min(step + cluster, last_step + 1);
    values += encode_number(
        nearest_mm(ranges_m, step - seen_first, end - seen_first, parameters.range_min_mm), 2);
  }
  std::string lines;
  for (std::size_t at = 0; at < values.size(); at += kBlock) {
    lines += values.substr(at, kBlock) + "\n";
  }
  return lines;
}

/// What the emulated laser replies to a request of SCIP 1.1, and does.
struct Scip1Answer {
  std::string text;
  bool scan = false;             ///< a scan: sent when the turn that measures it has ended
  bool leave = false;            ///< from now on it speaks SCIP 2.0
  std::optional<bool> laser_on;  ///< switched
  int baud = 0;                  ///< to change to; 0 = none
};

/// SCIP 1.1, the protocol of the first URG-04LX: echo, one character of status, data without
/// checksums, an empty line. Distances have two characters.
/// @param has_baud  on RS-232, where the speed can be changed
Scip1Answer answer_scip1(const std::string& line,
                         const HokuyoMirror& mirror,
                         bool has_baud,
                         Utime now) {
  Scip1Answer answer;
  std::string status = "0", data;
  int first = 0, last = 0, cluster = 0, used = 0;
  char command[2] = "";
  if (line == "SCIP2.0") {
    answer.leave = true;
  } else if (line == "V") {
    data =
        "VEND:Hokuyo Automatic Co.,Ltd.\nPROD:SOKUIKI Sensor URG-04LX\nFIRM:1.1.00\n"
        "PROT:00003,(SCIP 1.0)\nSERI:H0000001\nSTAT:Sensor works well.\n";
  } else if (line == "L0" || line == "L1") {
    answer.laser_on = line == "L1";
  } else if (line.size() == 14 && line[0] == 'S' && has_baud) {
    const int baud = std::atoi(line.substr(1, 6).c_str());
    const bool known = std::find(kBauds.begin(), kBauds.end(), baud) != kBauds.end();
    answer.baud = known ? baud : 0;
    if (!known) status = "E";
  } else if (std::sscanf(line.c_str(), "%1[G]%3d%3d%2d%n", command, &first, &last, &cluster,
                         &used) == 4 &&
             used == 9 && line.size() == 9 && first <= last && last <= kLastStep) {
    data = scan_lines(mirror, first, last, std::max(1, cluster), now);
    answer.scan = true;
  } else {
    status = "E";
  }
  answer.text = line + "\n" + status + "\n" + data + "\n";
  return answer;
}

std::string six_digits(uint32_t milliseconds) { return format("%06X", milliseconds & 0xFFFFFFU); }

}  // namespace

Parameters parameters_of_model(const std::string& model) {
  if (model == "URG-04LX") return {};
  if (model == "UST-10LX") return {"UST-10LX", 20, 30'000, 1440, 0, 1080, 540, 2400};
  require(model == "UTM-30LX",
          "the Hokuyo emulator knows URG-04LX, UTM-30LX and UST-10LX, not " + model);
  return {"UTM-30LX", 23, 60'000, 1440, 0, 1080, 540, 2400};
}

HokuyoEmulator::HokuyoEmulator(LaserWorld world, const HokuyoEmulatorOptions& options)
    : options_(options),
      mirror_(std::move(world), parameters_of_model(options.model)),
      output_(options.baud),
      speed_{options.baud} {
  validate(options, "hokuyo_emulator");
  scip1_ = options.scip1;
}

void HokuyoEmulator::on_connection(bool connected, Utime now) {
  if (!connected) line_.clear();
  if (mirror_.powered()) return;
  mirror_.set_power_on(now);
  ready_ = now;
}

void HokuyoEmulator::power_cycle(Utime now) {
  output_.clear();
  line_.clear();
  stream_.reset();
  laser_on_ = timing_ = false;
  reboot_ = {};
  scip1_ = options_.scip1;
  speed_ = {options_.baud};
  output_.set_baud(speed_.baud);
  mirror_.set_power_on(now);
  ready_ = now + Duration::from_seconds(options_.start_s);
}

void HokuyoEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  if (now < ready_ || (speed_.baud != 0 && baud != speed_.baud)) return;
  for (const uint8_t byte : bytes) {
    if (byte == '\n' || byte == '\r') {
      const std::string line = std::exchange(line_, {});
      if (!line.empty()) handle(line, now);
    } else if (line_.size() < kMaxRequestLine) {
      line_ += static_cast<char>(byte);
    }
  }
}

void HokuyoEmulator::answer(const Reply& reply, const std::string& tag, Utime now) {
  output_.send(encode_reply(reply, tag), now + Duration::from_seconds(options_.reply_s));
}

void HokuyoEmulator::handle_scip1(const std::string& line, Utime now) {
  const Scip1Answer reply = answer_scip1(line, mirror_, speed_.baud != 0, now);
  if (reply.leave) scip1_ = false;
  if (reply.laser_on) laser_on_ = *reply.laser_on;
  if (reply.baud != 0) speed_.after_reply = reply.baud;
  const double wait_s = options_.reply_s + (reply.scan ? 2.0 * mirror_.turn_s() : 0.0);
  output_.send(Bytes(reply.text.begin(), reply.text.end()), now + Duration::from_seconds(wait_s));
}

void HokuyoEmulator::handle(const std::string& line_with_tag, Utime now) {
  if (scip1_) return handle_scip1(line_with_tag, now);
  const std::size_t semicolon = std::min(line_with_tag.find(';'), line_with_tag.size());
  const std::string line = line_with_tag.substr(0, semicolon);
  const std::string tag = line_with_tag.substr(semicolon);
  const std::string command = line.substr(0, 2);
  const bool second_reboot = std::exchange(reboot_.asked, false);
  if (command == "VV") {
    answer(
        {line,
         "00",
         {key_line("VEND", "Hokuyo Automatic Co.,Ltd."),
          key_line("PROD",
                   (is_urg() ? "SOKUIKI Sensor " : "") +
                       mirror_.parameters().model.substr(0, mirror_.parameters().model.find('('))),
          key_line("FIRM", "3.3.00"), key_line("PROT", "SCIP 2.0"), key_line("SERI", "H0000001")}},
        tag, now);
  } else if (command == "PP") {
    answer(encode_parameters(mirror_.parameters()), tag, now);
  } else if (command == "II") {
    answer(
        {line,
         "00",
         {key_line("MODL", mirror_.parameters().model), key_line("LASR", laser_on_ ? "ON" : "OFF"),
          key_line("SCSP", std::to_string(mirror_.parameters().rpm)),
          key_line("MESM", stream_ ? "000" : "Idle"),
          key_line("SBPS", std::to_string(speed_.baud == 0 ? 115'200 : speed_.baud)),
          key_line("TIME", six_digits(mirror_.clock_ms(now))),
          key_line("STAT", is_urg() ? "Sensor works well." : "Stable 000 no error.")}},
        tag, now);
  } else if (command == "SS" && !is_ust()) {
    handle_speed(line, tag, now);
  } else if (line == "TM1" && timing_) {
    answer({line, "00", {encode_number(mirror_.clock_ms(now), 4)}}, tag, now);
  } else if (command == "TM") {
    answer({line, handle_time(line), {}}, tag, now);
  } else if (command == "RB" && line.size() == 2) {
    reboot_.asked = !second_reboot;
    answer({line, second_reboot ? "00" : "01", {}}, tag, now);
    if (second_reboot) reboot_.at = now + Duration::from_seconds(options_.reply_s);
  } else if (timing_) {
    answer({line, "0E", {}}, tag, now);  // nothing else until TM2
  } else if (parse_scan_request(line)) {
    handle_scan(line, tag, now);
  } else {
    answer({line, handle_state(line, now), {}}, tag, now);
  }
}

std::string HokuyoEmulator::handle_state(const std::string& line, Utime now) {
  const std::string command = line.substr(0, 2);
  if (command == "BM") return std::exchange(laser_on_, true) ? "02" : "00";
  if (command == "QT" || command == "RS" || command == "RT") {
    laser_on_ = false;
    stream_.reset();
    if (command != "QT") mirror_.set_power_on(now);
    return "00";
  }
  // As a real URG-04LX was seen to answer.
  if (line == "HS0" && is_urg()) return "0C";
  if (command == "CR" && is_urg() && laser_on_) return "03";
  if (command == "HS" || command == "CR") return "00";
  return line == "SCIP2.0" && !is_ust() ? "00" : "0E";
}

std::string HokuyoEmulator::handle_time(const std::string& line) {
  if (line == "TM2") return std::exchange(timing_, false) ? "00" : "03";
  if (line != "TM0") return line == "TM1" ? "04" : "01";
  stream_.reset();
  return std::exchange(timing_, true) ? "02" : "00";
}

void HokuyoEmulator::handle_speed(const std::string& line, const std::string& tag, Utime now) {
  int baud = 0;
  for (const int one : {19'200, 38'400, 57'600, 115'200, 250'000, 500'000, 750'000}) {
    if (line == format("SS%06d", one)) baud = one;
  }
  answer({line, baud == 0 ? "03" : "00", {}}, tag, now);
  if (baud != 0 && speed_.baud != 0) speed_.after_reply = baud;
}

void HokuyoEmulator::handle_scan(const std::string& line, const std::string& tag, Utime now) {
  const ScanRequest request = *parse_scan_request(line);
  const bool able =
      mirror_.parameters().range_max_mm > 5600 ||  // the URG tells first distances only
      (!request.intensities && !request.all_echoes);
  if (!able) return answer({line, "0E", {}}, tag, now);
  const bool in_view = request.last_step <= mirror_.parameters().last_step &&
                       (request.characters == 3 || mirror_.parameters().range_max_mm <= 5600);
  if (!in_view) return answer({line, "04", {}}, tag, now);
  if (!request.stream && !laser_on_) return answer({line, "10", {}}, tag, now);
  laser_on_ = true;
  stream_ = Stream{request, tag, request.count, mirror_.turn_after(now)};
  if (request.stream) answer({line, "00", {}}, tag, now);
}

Utime HokuyoEmulator::scan_end() const {
  return mirror_.time_of(stream_->turn, stream_->request.last_step);
}

void HokuyoEmulator::finish_scan() {
  const ScanRequest& request = stream_->request;
  int& remaining = stream_->remaining;
  const Measurement scan = mirror_.measure(request, stream_->turn);
  if (remaining > 0) --remaining;
  output_.send(encode_reply(encode_measurement(request, remaining, scan), stream_->tag),
               scan_end());
  ++scans_sent_;
  if (!request.stream || (request.count > 0 && remaining == 0)) {
    stream_.reset();
    return;
  }
  do {
    stream_->turn += 1 + request.skip;
  } while (scan_end() < output_.free_at());
}

void HokuyoEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  while (stream_ && now >= scan_end()) finish_scan();
  output_.advance(now, out);
  if (reboot_.at && output_.empty()) power_cycle(*reboot_.at);
  if (speed_.after_reply != 0 && output_.empty()) {
    speed_.baud = std::exchange(speed_.after_reply, 0);
    output_.set_baud(speed_.baud);
  }
}

Utime HokuyoEmulator::next_event() const {
  const Utime next = output_.next_event();
  return stream_ ? std::min(next, scan_end()) : next;
}

}  // namespace marco::drivers::hokuyo
