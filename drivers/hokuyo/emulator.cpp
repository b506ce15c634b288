#include "drivers/hokuyo/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::hokuyo {
namespace {

constexpr std::size_t kMaxRequestLine = 64;
constexpr uint32_t kNoEcho = 1;  // an error code: below DMIN

}  // namespace

Parameters parameters_of_model(const std::string& model) {
  if (model == "URG-04LX") return {};
  require(model == "UTM-30LX", "the Hokuyo emulator knows URG-04LX and UTM-30LX, not " + model);
  return {"UTM-30LX", 23, 60'000, 1440, 0, 1080, 540, 2400};
}

HokuyoEmulator::HokuyoEmulator(LaserWorld world, const HokuyoEmulatorOptions& options)
    : world_(std::move(world)),
      options_(options),
      parameters_(parameters_of_model(options.model)),
      output_(options.baud),
      baud_(options.baud) {
  validate(options, "hokuyo_emulator");
  scip1_ = options.scip1;
}

void HokuyoEmulator::on_connection(bool connected, Utime now) {
  if (!connected) line_.clear();
  if (power_on_.us == 0) power_on_ = ready_ = now;
}

void HokuyoEmulator::power_cycle(Utime now) {
  output_.clear();
  line_.clear();
  stream_.reset();
  laser_on_ = timing_ = reboot_asked_ = false;
  reboot_.reset();
  scip1_ = options_.scip1;
  baud_ = options_.baud;
  output_.set_baud(baud_);
  baud_after_reply_ = 0;
  power_on_ = now;
  ready_ = now + Duration::from_seconds(options_.start_s);
}

Utime HokuyoEmulator::turn_start(int64_t turn) const {
  return power_on_ + Duration::from_seconds(static_cast<double>(turn) * turn_s());
}

double HokuyoEmulator::from_rear_s(int step) const {
  const int from_rear = step - parameters_.front_step + parameters_.steps_per_turn / 2;
  return turn_s() * from_rear / parameters_.steps_per_turn;
}

void HokuyoEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  if (now < ready_ || (baud_ != 0 && baud != baud_)) return;
  for (const uint8_t byte : bytes) {
    if (byte == '\n' || byte == '\r') {
      const std::string line = std::exchange(line_, {});
      if (!line.empty()) handle(line, now);
    } else if (line_.size() < kMaxRequestLine) {
      line_ += static_cast<char>(byte);
    }
  }
}

void HokuyoEmulator::answer(Reply reply, const std::string& tag, Utime now) {
  output_.send(encode_reply(reply, tag), now + Duration::from_seconds(options_.reply_s));
}

uint32_t HokuyoEmulator::clock_ms(Utime now) const {
  return static_cast<uint32_t>((now - power_on_).us / 1000) & 0xFFFFFFU;
}

void HokuyoEmulator::handle(const std::string& line_with_tag, Utime now) {
  if (scip1_) return handle_scip1(line_with_tag, now);
  const std::size_t semicolon = std::min(line_with_tag.find(';'), line_with_tag.size());
  const std::string line = line_with_tag.substr(0, semicolon);
  const std::string tag = line_with_tag.substr(semicolon);
  const std::string command = line.substr(0, 2);
  const bool second_reboot = std::exchange(reboot_asked_, false);
  if (command == "VV") {
    answer(
        {line,
         "00",
         {key_line("VEND", "Hokuyo Automatic Co.,Ltd."),
          key_line("PROD", parameters_.model.substr(0, parameters_.model.find('('))),
          key_line("FIRM", "3.3.00"), key_line("PROT", "SCIP 2.0"), key_line("SERI", "H0000001")}},
        tag, now);
  } else if (command == "PP") {
    answer(encode_parameters(parameters_), tag, now);
  } else if (command == "II") {
    answer(
        {line,
         "00",
         {key_line("MODL", parameters_.model), key_line("LASR", laser_on_ ? "ON" : "OFF"),
          key_line("SCSP", std::to_string(parameters_.rpm)),
          key_line("MESM", stream_ ? "000" : "Idle"),
          key_line("SBPS", std::to_string(baud_ == 0 ? 115'200 : baud_)),
          key_line("TIME", std::to_string(clock_ms(now))), key_line("STAT", "Sensor works well.")}},
        tag, now);
  } else if (command == "SS") {
    handle_speed(line, tag, now);
  } else if (line == "TM1" && timing_) {
    answer({line, "00", {encode_number(clock_ms(now), 4)}}, tag, now);
  } else if (command == "TM") {
    answer({line, handle_time(line), {}}, tag, now);
  } else if (command == "RB" && line.size() == 2) {
    reboot_asked_ = !second_reboot;
    answer({line, second_reboot ? "00" : "01", {}}, tag, now);
    if (second_reboot) reboot_ = now + Duration::from_seconds(options_.reply_s);
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
    if (command != "QT") power_on_ = now;
    return "00";
  }
  if (command == "HS" || command == "CR" || line == "SCIP2.0") return "00";
  return "0E";
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
    char name[16];
    std::snprintf(name, sizeof(name), "SS%06d", one);
    if (line == name) baud = one;
  }
  answer({line, baud == 0 ? "03" : "00", {}}, tag, now);
  if (baud != 0 && baud_ != 0) baud_after_reply_ = baud;
}

void HokuyoEmulator::handle_scan(const std::string& line, const std::string& tag, Utime now) {
  const ScanRequest request = *parse_scan_request(line);
  const bool able = parameters_.range_max_mm > 5600 ||  // the URG tells first distances only
                    (!request.intensities && !request.all_echoes);
  if (!able) return answer({line, "0E", {}}, tag, now);
  const bool in_view = request.last_step <= parameters_.last_step &&
                       (request.characters == 3 || parameters_.range_max_mm <= 5600);
  if (!in_view) return answer({line, "04", {}}, tag, now);
  if (!request.stream && !laser_on_) return answer({line, "10", {}}, tag, now);
  laser_on_ = true;
  stream_ = request;
  stream_tag_ = tag;
  remaining_ = request.count;
  if (request.stream) answer({line, "00", {}}, tag, now);
  schedule(now);
}

void HokuyoEmulator::schedule(Utime not_before) {
  const double turns = (not_before - power_on_).seconds() / turn_s();
  turn_ = static_cast<int64_t>(std::ceil(turns));
}

void HokuyoEmulator::finish_scan() {
  const ScanRequest request = *stream_;
  LaserSweep sweep;
  const double step_rad = 2.0 * std::numbers::pi / parameters_.steps_per_turn;
  sweep.first_beam = turn_start(turn_) + Duration::from_seconds(from_rear_s(request.first_step));
  sweep.beam_interval_s = turn_s() / parameters_.steps_per_turn * request.cluster;
  sweep.first_bearing_rad = (request.first_step - parameters_.front_step) * step_rad;
  sweep.bearing_step_rad = step_rad * request.cluster;
  sweep.beams = request.values();
  Measurement scan;
  scan.timestamp_ms = static_cast<uint32_t>((turn_start(turn_) - power_on_).us / 1000) & 0xFFFFFFu;
  const int64_t largest =
      std::min(parameters_.range_max_mm, request.characters == 3 ? 262'143 : 4095);
  for (const double range_m : world_(sweep)) {
    const bool good = std::isfinite(range_m) && range_m >= 0.001 * parameters_.range_min_mm &&
                      std::lround(range_m * 1000.0) <= largest;
    scan.values_mm.push_back(good ? static_cast<uint32_t>(std::lround(range_m * 1000.0)) : kNoEcho);
    // A grey wall's: it falls with the distance. The world knows no colours.
    if (request.intensities) {
      scan.intensities.push_back(good ? static_cast<uint32_t>(4000.0 / (1.0 + range_m)) : 0);
    }
  }
  const Utime end = turn_start(turn_) + Duration::from_seconds(from_rear_s(request.last_step));
  if (remaining_ > 0) --remaining_;
  output_.send(encode_reply(encode_measurement(request, remaining_, scan), stream_tag_), end);
  ++scans_sent_;
  last_first_beam_ = sweep.first_beam;
  last_measurement_ = std::move(scan);
  if (!request.stream || (request.count > 0 && remaining_ == 0)) {
    stream_.reset();
    return;
  }
  do {
    turn_ += 1 + request.skip;
  } while (turn_start(turn_) + Duration::from_seconds(from_rear_s(request.last_step)) <
           output_.free_at());
}

void HokuyoEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  while (stream_ &&
         now >= turn_start(turn_) + Duration::from_seconds(from_rear_s(stream_->last_step))) {
    finish_scan();
  }
  output_.advance(now, out);
  if (reboot_ && output_.empty()) power_cycle(*reboot_);
  if (baud_after_reply_ != 0 && output_.empty()) {
    baud_ = std::exchange(baud_after_reply_, 0);
    output_.set_baud(baud_);
  }
}

Utime HokuyoEmulator::next_event() const {
  Utime next = output_.next_event();
  if (stream_) {
    next =
        std::min(next, turn_start(turn_) + Duration::from_seconds(from_rear_s(stream_->last_step)));
  }
  return next;
}

}  // namespace marco::drivers::hokuyo
