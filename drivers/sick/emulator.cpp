#include "drivers/sick/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers::sick {
namespace {

// Silence inside a request after which its beginning is forgotten: far above the 6 ms a host may
// take, so that a busy machine's pauses do no harm.
constexpr Duration kRequestGap = Duration::from_us(200'000);
constexpr uint16_t kCleanWindow = 600, kDirtyWindow = 200;  // light that comes through

}  // namespace

SickEmulator::SickEmulator(LaserWorld world, const SickEmulatorOptions& options)
    : world_(std::move(world)), options_(options), output_(options.baud), baud_(options.baud) {
  validate(options, "sick_emulator");
  require(mode_of_baud(options.baud).has_value(), "the laser has no such baud rate");
  configuration_.bytes[3] = 2;
}

void SickEmulator::on_connection(bool connected, Utime now) {
  if (!connected) parser_.clear();
  if (mirror_start_.us == 0) mirror_start_ = now;
}

void SickEmulator::power_cycle(Utime now) {
  output_.clear();
  parser_.clear();
  baud_after_reply_ = 0;
  boot(now);
}

void SickEmulator::boot(Utime now) {
  booting_ = true;
  boot_end_ = now + Duration::from_seconds(options_.power_on_s);
  mode_ = kOnRequest;
  installation_ = one_scan_asked_ = false;
}

void SickEmulator::finish_boot(Utime now) {
  booting_ = false;
  if (!options_.permanent_baud) baud_ = options_.baud;
  output_.set_baud(baud_);
  mirror_start_ = boot_end_;
  Bytes hello{kPowerOnReply};
  hello.insert(hello.end(), options_.type.begin(), options_.type.end());
  hello.push_back(' ');
  reply(hello, now, 0.0);
}

bool SickEmulator::streaming() const {
  return !booting_ && mode_ != kOnRequest && mode_ != kDiagnosis;
}

void SickEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  client_baud_ = baud;
  if (booting_ || (baud != 0 && baud != baud_)) return;
  if (now - last_byte_ > kRequestGap) parser_.clear();
  if (!bytes.empty()) last_byte_ = now;
  parser_.push(bytes);
  while (const auto event = parser_.next()) {
    const Utime answer = now + Duration::from_seconds(options_.reply_s);
    if (event->kind == Event::Kind::bad_checksum) {
      output_.send(Bytes{kNak}, answer);
    } else if (event->address == 0 || event->address == (options_.address & 0x7F)) {
      output_.send(Bytes{kAck}, answer);
      handle(*event, now);
    }
    if (booting_) return;
  }
}

void SickEmulator::reply(const Bytes& payload, Utime now, double after_s) {
  const auto status = static_cast<uint8_t>(kHealthy | (options_.polluted ? 0x80 : 0));
  output_.send(encode_reply(payload, status, static_cast<uint8_t>(options_.address)),
               now + Duration::from_seconds(options_.reply_s + after_s));
}

void SickEmulator::handle(const Event& request, Utime now) {
  const std::span<const uint8_t> data = request.payload.subspan(1);
  switch (request.code()) {
    case kReset:
      reply({kResetReply}, now, 0.0);
      boot(output_.free_at());
      return;
    case kSetMode:
      return set_mode(data, now);
    case kGetValues:
      if (data.size() == 1 && data[0] == 1 && ask_one(kContinuous, {}, now)) return;
      break;
    case kGetMean:
      if (ask_one(kMean, data, now)) return;
      break;
    case kGetSubRange:
      if (ask_one(kSubRange, data, now)) return;
      break;
    case kGetMeanSubRange:
      if (ask_one(kMeanSubRange, data, now)) return;
      break;
    case kGetStatus:
      return reply_status(now);
    case kGetErrors:
      // Kind (the severity) and number of each; the number is ours.
      return reply(options_.polluted ? Bytes{kGetErrors | 0x80, 2, 20} : Bytes{kGetErrors | 0x80},
                   now, 0.0);
    case kGetType: {
      Bytes payload{kGetType | 0x80};
      payload.insert(payload.end(), options_.type.begin(), options_.type.end());
      return reply(payload, now, 0.0);
    }
    case kSetVariant:
      return set_variant(data, now);
    case kGetConfiguration: {
      Bytes payload{kGetConfiguration | 0x80};
      payload.insert(payload.end(), configuration_.bytes.begin(), configuration_.bytes.end());
      return reply(payload, now, 0.0);
    }
    case kSetConfiguration:
      return set_configuration(data, now);
    default:
      break;
  }
  reply({kRejectedReply}, now, 0.0);
}

bool SickEmulator::take_arguments(uint8_t form, std::span<const uint8_t> data) {
  const bool mean = form == kMean || form == kMeanSubRange;
  const bool part = form == kSubRange || form == kMeanSubRange || form == kReflectivity;
  if (data.size() != (mean ? 1u : 0u) + (part ? 4u : 0u)) return false;
  if (mean && (data[0] < 2 || data[0] > 250)) return false;
  const std::span<const uint8_t> range = data.subspan(mean ? 1 : 0);
  if (part) {
    const auto first = static_cast<uint16_t>(range[0] | range[1] << 8);
    const auto last = static_cast<uint16_t>(range[2] | range[3] << 8);
    if (first < 1 || first > last || last > beams_of_variant(angle_deg_, resolution_cdeg_)) {
      return false;
    }
    sub_range_ = {first, last};
  }
  samples_ = mean ? data[0] : 0;
  return true;
}

bool SickEmulator::ask_one(uint8_t form, std::span<const uint8_t> arguments, Utime now) {
  if (mode_ != kOnRequest || !take_arguments(form, arguments)) return false;
  form_ = form;
  summed_.clear();
  one_scan_asked_ = true;
  schedule_turn(now);
  return true;
}

bool SickEmulator::accepts_mode(std::span<const uint8_t> data) {
  const uint8_t mode = data[0];
  switch (mode) {
    case kInstallation:
      return std::string(data.begin() + 1, data.end()) == "SICK_LMS";
    case kDiagnosis:
    case kOnRequest:
      return true;
    case kReflectivity:
      if (options_.type.find("S14") == std::string::npos) return false;  // not a fast model
      [[fallthrough]];
    case kContinuous:
    case kMean:
    case kSubRange:
    case kMeanSubRange:
    case kPartialScans:
      return take_arguments(mode, data.subspan(1));
    default:
      // Segments, fields and navigation: no source says what such streams look like.
      return baud_of_mode(mode).has_value();
  }
}

void SickEmulator::set_mode(std::span<const uint8_t> data, Utime now) {
  if (data.empty()) return reply({kRejectedReply}, now, 0.0);
  const uint8_t mode = data[0];
  const bool accepted = accepts_mode(data);
  reply({kSetMode | 0x80, static_cast<uint8_t>(accepted ? 0 : 1)}, now, options_.mode_change_s);
  if (!accepted) return;
  if (const auto new_baud = baud_of_mode(mode)) {
    baud_after_reply_ = *new_baud;
    return;
  }
  installation_ = mode == kInstallation;
  start_measuring(installation_ ? static_cast<uint8_t>(kOnRequest) : mode, output_.free_at());
}

void SickEmulator::start_measuring(uint8_t mode, Utime now) {
  mode_ = form_ = mode;
  one_scan_asked_ = false;
  summed_.clear();
  if (streaming()) schedule_turn(now);
}

void SickEmulator::set_variant(std::span<const uint8_t> data, Utime now) {
  if (data.size() != 4) return reply({kRejectedReply}, now, 0.0);
  const int angle_deg = data[0] | data[1] << 8;
  const int resolution_cdeg = data[2] | data[3] << 8;
  const bool accepted = beams_of_variant(angle_deg, resolution_cdeg) > 0;
  Bytes payload{kSetVariant | 0x80, static_cast<uint8_t>(accepted ? 1 : 0)};
  payload.insert(payload.end(), data.begin(), data.end());
  reply(payload, now, options_.mode_change_s);
  if (!accepted) return;
  angle_deg_ = angle_deg;
  resolution_cdeg_ = resolution_cdeg;
  mode_ = kOnRequest;
}

void SickEmulator::set_configuration(std::span<const uint8_t> data, Utime now) {
  if (!installation_ || data.size() < 7) return reply({kRejectedReply}, now, 0.0);
  Configuration wanted = configuration_;
  std::copy_n(data.begin(), std::min(data.size(), wanted.bytes.size()), wanted.bytes.begin());
  bool accepted = data[6] <= 1;
  try {
    range_rule(wanted.measuring_mode());
  } catch (const std::invalid_argument&) {
    accepted = false;
  }
  if (accepted) configuration_ = wanted;
  Bytes payload{kSetConfiguration | 0x80, static_cast<uint8_t>(accepted ? 1 : 0)};
  payload.insert(payload.end(), configuration_.bytes.begin(), configuration_.bytes.end());
  reply(payload, now, options_.configure_s);
}

void SickEmulator::reply_status(Utime now) {
  StatusReport report;
  report.firmware = options_.type.substr(options_.type.rfind(';') + 1);
  report.boot_firmware = "V01.10";
  report.mode = installation_ ? static_cast<uint8_t>(kInstallation) : mode_;
  report.variant_type = 1;
  report.pollution_calibration.fill(kCleanWindow);
  report.reference_calibration.fill(kCleanWindow);
  report.reference_pollution.fill(kCleanWindow);
  report.pollution.fill(options_.polluted ? kDirtyWindow : kCleanWindow);
  report.restart_mode = configuration_.bytes[10];
  report.evaluations = configuration_.bytes[9];
  report.laser_on = true;
  report.motor_revolutions = static_cast<int>(std::lround(60.0 / options_.turn_s));
  report.measuring_mode = configuration_.measuring_mode();
  report.angle_deg = angle_deg_;
  report.resolution_cdeg = resolution_cdeg_;
  report.baud = baud_;
  report.permanent_baud = options_.permanent_baud;
  report.address = static_cast<uint8_t>(options_.address & 0x7F);
  report.unit = configuration_.unit();
  reply(encode_status(report), now, 0.0);
}

void SickEmulator::garble(std::vector<uint8_t>& out, std::size_t from) const {
  for (std::size_t i = from; i < out.size(); ++i) {
    out[i] = static_cast<uint8_t>((std::size_t{out[i]} * 37 + i * 11) | 0x80);
  }
}

void SickEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  if (booting_ && now >= boot_end_ && output_.empty()) finish_boot(boot_end_);
  // All that are over: a busy machine's emulator must not fall behind its mirror.
  while ((streaming() || one_scan_asked_) && turn_end_time() <= now) finish_turn();
  const std::size_t from = out.size();
  output_.advance(now, out);
  if (client_baud_ != 0 && client_baud_ != baud_) garble(out, from);
  if (baud_after_reply_ != 0 && output_.empty()) {
    baud_ = std::exchange(baud_after_reply_, 0);
    output_.set_baud(baud_);
  }
}

Utime SickEmulator::next_event() const {
  Utime next = output_.next_event();
  if (booting_ && output_.empty()) next = std::min(next, boot_end_);
  if (streaming() || one_scan_asked_) {
    next = std::min(next, turn_end_time());
  }
  return next;
}

}  // namespace marco::drivers::sick
