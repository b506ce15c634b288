#include "simulator/devices/sick/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers::sick {
namespace {

// A request interrupted for longer is forgotten. Far above the 6 ms that a host may take, so that
// the pauses of a busy machine do no harm.
constexpr Duration kRequestGap = Duration::from_us(200'000);
constexpr uint16_t kCleanWindow = 600, kDirtyWindow = 200;  // light that comes through

}  // namespace

SickEmulator::SickEmulator(LaserWorld world, const SickEmulatorOptions& options)
    : options_(options),
      output_(options.baud),
      mirror_(std::move(world), options.turn_s),
      speed_{options.baud} {
  validate(options, "sick_emulator");
  require(mode_of_baud(options.baud).has_value(), "the laser has no such baud rate");
  configuration_.bytes[3] = 2;
}

void SickEmulator::on_connection(bool connected, Utime now) {
  if (!connected) parser_.clear();
  if (!mirror_.turning()) mirror_.start(now);
}

void SickEmulator::power_cycle(Utime now) {
  output_.clear();
  parser_.clear();
  speed_.after_reply = 0;
  boot(now);
}

void SickEmulator::boot(Utime now) {
  boot_end_ = now + Duration::from_seconds(options_.power_on_s);
  mode_ = kOnRequest;
  one_scan_asked_ = false;
}

void SickEmulator::finish_boot(Utime now) {
  boot_end_.reset();
  if (!options_.permanent_baud) speed_.baud = options_.baud;
  output_.set_baud(speed_.baud);
  mirror_.start(now);
  Bytes hello{kPowerOnReply};
  hello.insert(hello.end(), options_.type.begin(), options_.type.end());
  hello.push_back(' ');
  reply(hello, now, 0.0);
}

bool SickEmulator::streaming() const {
  return !boot_end_ && mode_ != kOnRequest && mode_ != kDiagnosis && mode_ != kInstallation;
}

void SickEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  speed_.client = baud;
  if (boot_end_ || (baud != 0 && baud != speed_.baud)) return;
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
    if (boot_end_) return;
  }
}

void SickEmulator::reply(const Bytes& payload, Utime now, double after_s) {
  output_.send(encode_reply(payload, status_byte(), static_cast<uint8_t>(options_.address)),
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

std::optional<SickMirror::Form> SickEmulator::form_of(uint8_t mode,
                                                      std::span<const uint8_t> data) const {
  const bool mean = mode == kMean || mode == kMeanSubRange;
  const bool part = mode == kSubRange || mode == kMeanSubRange || mode == kReflectivity;
  if (data.size() != (mean ? 1u : 0u) + (part ? 4u : 0u)) return std::nullopt;
  if (mean && (data[0] < 2 || data[0] > 250)) return std::nullopt;
  SickMirror::Form form{mode, mean ? data[0] : uint8_t{0}};
  if (!part) return form;
  const std::span<const uint8_t> range = data.subspan(mean ? 1 : 0);
  form.sub_range = {static_cast<uint16_t>(range[0] | range[1] << 8),
                    static_cast<uint16_t>(range[2] | range[3] << 8)};
  const SickMirror::Variant& variant = mirror_.variant();
  const auto& [first, last] = form.sub_range;
  if (first < 1 || first > last ||
      last > beams_of_variant(variant.angle_deg, variant.resolution_cdeg)) {
    return std::nullopt;
  }
  return form;
}

bool SickEmulator::ask_one(uint8_t mode, std::span<const uint8_t> arguments, Utime now) {
  const auto form = form_of(mode, arguments);
  if (!form || (mode_ != kOnRequest && mode_ != kInstallation)) return false;
  one_scan_asked_ = true;
  mirror_.begin(*form, now);
  return true;
}

bool SickEmulator::accepts_mode(std::span<const uint8_t> data) const {
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
      return form_of(mode, data.subspan(1)).has_value();
    default:
      // Segments, fields and navigation: no source documents such streams.
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
    speed_.after_reply = *new_baud;
    return;
  }
  mode_ = mode;
  one_scan_asked_ = false;
  if (streaming()) mirror_.begin(*form_of(mode, data.subspan(1)), output_.free_at());
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
  mirror_.set_variant({angle_deg, resolution_cdeg});
  if (mode_ != kInstallation) mode_ = kOnRequest;
}

void SickEmulator::set_configuration(std::span<const uint8_t> data, Utime now) {
  if (mode_ != kInstallation || data.size() < 7) return reply({kRejectedReply}, now, 0.0);
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
  report.mode = mode_;
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
  report.angle_deg = mirror_.variant().angle_deg;
  report.resolution_cdeg = mirror_.variant().resolution_cdeg;
  report.baud = speed_.baud;
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

uint8_t SickEmulator::status_byte() const {
  return static_cast<uint8_t>(kHealthy | (options_.polluted ? 0x80 : 0));
}

void SickEmulator::finish_scan() {
  const Utime end = mirror_.scan_end();
  auto values = mirror_.finish_scan(configuration_);
  if (!values) return;
  if ((configuration_.availability() & 2) != 0) {
    values->indices = {mirror_.turn_index(), static_cast<uint8_t>(scans_sent_)};
  }
  output_.send(
      encode_reply(encode_values(*values), status_byte(), static_cast<uint8_t>(options_.address)),
      end);
  ++scans_sent_;
  one_scan_asked_ = false;
  scans_dropped_ += mirror_.skip_until(output_.free_at());
}

void SickEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  if (boot_end_ && now >= *boot_end_ && output_.empty()) finish_boot(*boot_end_);
  // More than one scan: on a busy machine the emulator must catch up with its mirror.
  while (measuring() && mirror_.scan_end() <= now) finish_scan();
  const std::size_t from = out.size();
  output_.advance(now, out);
  if (speed_.client != 0 && speed_.client != speed_.baud) garble(out, from);
  if (speed_.after_reply != 0 && output_.empty()) {
    speed_.baud = std::exchange(speed_.after_reply, 0);
    output_.set_baud(speed_.baud);
  }
}

Utime SickEmulator::next_event() const {
  Utime next = output_.next_event();
  if (boot_end_ && output_.empty()) next = std::min(next, *boot_end_);
  if (measuring()) next = std::min(next, mirror_.scan_end());
  return next;
}

}  // namespace marco::drivers::sick
