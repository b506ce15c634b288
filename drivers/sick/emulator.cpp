#include "drivers/sick/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::sick {
namespace {

// Silence inside a request after which its beginning is forgotten: far above the 6 ms a host may
// take, so that a busy machine's pauses do no harm.
constexpr Duration kRequestGap = Duration::from_us(200'000);
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

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
  return !booting_ && (mode_ == kContinuous || mode_ == kSubRange || mode_ == kPartialScans);
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
      if (mode_ != kOnRequest || data.size() != 1 || data[0] != 1) break;
      one_scan_asked_ = true;
      schedule_turn(now);
      return;
    case kGetStatus:
      return reply_status(now);
    case kGetErrors:
      return reply({kGetErrors | 0x80}, now, 0.0);
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

void SickEmulator::set_mode(std::span<const uint8_t> data, Utime now) {
  if (data.empty()) return reply({kRejectedReply}, now, 0.0);
  const uint8_t mode = data[0];
  const auto new_baud = baud_of_mode(mode);
  bool accepted = new_baud.has_value();
  if (mode == kContinuous || mode == kOnRequest || mode == kPartialScans) accepted = true;
  if (mode == kInstallation) {
    accepted = std::string(data.begin() + 1, data.end()) == "SICK_LMS";
  } else if (mode == kSubRange && data.size() == 5) {
    sub_range_ = {static_cast<uint16_t>(data[1] | data[2] << 8),
                  static_cast<uint16_t>(data[3] | data[4] << 8)};
    accepted = sub_range_[0] >= 1 && sub_range_[0] <= sub_range_[1] &&
               sub_range_[1] <= beams_of_variant(angle_deg_, resolution_cdeg_);
  }
  reply({kSetMode | 0x80, static_cast<uint8_t>(accepted ? 0 : 1)}, now, options_.mode_change_s);
  if (!accepted) return;
  if (new_baud) {
    baud_after_reply_ = *new_baud;
    return;
  }
  installation_ = mode == kInstallation;
  start_measuring(installation_ ? static_cast<uint8_t>(kOnRequest) : mode, output_.free_at());
}

void SickEmulator::start_measuring(uint8_t mode, Utime now) {
  mode_ = mode;
  one_scan_asked_ = false;
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
  if (options_.polluted) report.pollution.fill(200);
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

int SickEmulator::turns_per_scan() const { return partial_mode() ? 1 : 100 / resolution_cdeg_; }

void SickEmulator::schedule_turn(Utime not_before) {
  const double turns = (not_before - mirror_start_).seconds() / options_.turn_s;
  turn_end_ = static_cast<int64_t>(std::ceil(turns)) + turns_per_scan();
}

uint16_t SickEmulator::word_of_range(double range_m) const {
  const RangeRule rule = range_rule(configuration_.measuring_mode());
  if (std::isnan(range_m)) return word_of(Special::dazzled, rule);
  if (std::isinf(range_m)) return word_of(Special::no_echo, rule);
  const double units = std::max(0.0, range_m) / metres(configuration_.unit());
  if (units >= rule.first_special - 0.5) return word_of(Special::beyond_range, rule);
  return static_cast<uint16_t>(std::lround(units));
}

MeasuredValues SickEmulator::measure(Utime first_beam) const {
  const int turns = turns_per_scan();
  const int all_turns = 100 / resolution_cdeg_;
  MeasuredValues values;
  values.unit = configuration_.unit();
  int first_offset = 0;
  if (partial_mode()) {
    const auto turn = static_cast<int64_t>(
        std::llround((first_beam - mirror_start_).seconds() / options_.turn_s));
    first_offset = static_cast<int>(turn % all_turns);
    values.partial = true;
    values.partial_offset_quarters = first_offset * resolution_cdeg_ / 25;
  }
  const int whole = angle_deg_ + (turns > 1 || first_offset == 0 ? 1 : 0);
  values.words.resize(turns > 1 ? static_cast<std::size_t>(angle_deg_ * turns + 1)
                                : static_cast<std::size_t>(whole));
  for (int turn = 0; turn < turns; ++turn) {
    const int offset = first_offset + turn;
    LaserSweep sweep;
    sweep.first_beam =
        first_beam + Duration::from_seconds(turn * options_.turn_s +
                                            offset * resolution_cdeg_ / 36000.0 * options_.turn_s);
    sweep.beam_interval_s = options_.turn_s / 360.0;
    sweep.first_bearing_rad = (-0.5 * angle_deg_ + offset * resolution_cdeg_ * 0.01) * kRadPerDeg;
    sweep.bearing_step_rad = kRadPerDeg;
    sweep.beams = angle_deg_ + (offset == 0 ? 1 : 0);
    const std::vector<double> ranges_m = world_(sweep);
    for (std::size_t i = 0; i < ranges_m.size() && i < static_cast<std::size_t>(sweep.beams); ++i) {
      values.words[i * static_cast<std::size_t>(turns) + static_cast<std::size_t>(turn)] =
          word_of_range(ranges_m[i]);
    }
  }
  return values;
}

void SickEmulator::finish_turn(Utime now) {
  const int turns = turns_per_scan();
  const Utime end =
      mirror_start_ + Duration::from_seconds(static_cast<double>(turn_end_) * options_.turn_s);
  if (now < end) return;
  const Utime first_beam = end - Duration::from_seconds(turns * options_.turn_s);
  MeasuredValues values = measure(first_beam);
  if (mode_ == kSubRange) {
    values.sub_range = sub_range_;
    values.words = {values.words.begin() + sub_range_[0] - 1, values.words.begin() + sub_range_[1]};
  }
  if ((configuration_.availability() & 2) != 0) {
    const auto index = static_cast<uint8_t>(scans_sent_);
    values.indices = {static_cast<uint8_t>(turn_end_), index};
  }
  const auto status = static_cast<uint8_t>(kHealthy | (options_.polluted ? 0x80 : 0));
  output_.send(encode_reply(encode_values(values), status, static_cast<uint8_t>(options_.address)),
               end);
  ++scans_sent_;
  last_values_ = std::move(values);
  last_first_beam_ = first_beam;
  one_scan_asked_ = false;
  // Scans that end while the line is taken are never sent.
  const int64_t was = turn_end_;
  do {
    turn_end_ += turns;
  } while (mirror_start_ +
               Duration::from_seconds(static_cast<double>(turn_end_) * options_.turn_s) <
           output_.free_at());
  scans_dropped_ += (turn_end_ - was) / turns - 1;
}

void SickEmulator::garble(std::vector<uint8_t>& out, std::size_t from) const {
  for (std::size_t i = from; i < out.size(); ++i) {
    out[i] = static_cast<uint8_t>((std::size_t{out[i]} * 37 + i * 11) | 0x80);
  }
}

void SickEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  if (booting_ && now >= boot_end_ && output_.empty()) finish_boot(boot_end_);
  if (streaming() || one_scan_asked_) finish_turn(now);
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
    next = std::min(next, mirror_start_ + Duration::from_seconds(static_cast<double>(turn_end_) *
                                                                 options_.turn_s));
  }
  return next;
}

}  // namespace marco::drivers::sick
