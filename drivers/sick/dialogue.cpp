#include "drivers/sick/dialogue.hpp"

#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::sick {
namespace {

constexpr Duration kAckPatience = Duration::from_us(120'000);  // the device's promise: 60 ms
constexpr Duration kReplyPatience = Duration::from_us(1'000'000);
constexpr Duration kConfigurePatience = Duration::from_us(15'000'000);

}  // namespace

Bytes Dialogue::request(Phase phase, int goal_baud) const {
  switch (phase) {
    case Phase::changing_baud:
      return set_mode_request(*mode_of_baud(goal_baud));
    case Phase::asking_type:
      return encode_request(Bytes{kGetType});
    case Phase::checking_baud:
    case Phase::asking_status:
      return encode_request(Bytes{kGetStatus});
    case Phase::setting_variant:
      return set_variant_request(options_.angle_deg, options_.resolution_cdeg());
    case Phase::reading_configuration:
      return encode_request(Bytes{kGetConfiguration});
    case Phase::entering_installation:
      return installation_request(options_.password);
    case Phase::configuring:
      return set_configuration_request(wanted_);
    case Phase::starting:
      return set_mode_request(options_.interlaced ? kPartialScans : kContinuous);
    default:
      return set_mode_request(kOnRequest);
  }
}

uint8_t Dialogue::reply_code(Phase phase) {
  switch (phase) {
    case Phase::asking_type:
      return kGetType | 0x80;
    case Phase::checking_baud:
    case Phase::asking_status:
      return kGetStatus | 0x80;
    case Phase::setting_variant:
      return kSetVariant | 0x80;
    case Phase::reading_configuration:
      return kGetConfiguration | 0x80;
    case Phase::configuring:
      return kSetConfiguration | 0x80;
    default:
      return kSetMode | 0x80;
  }
}

Duration Dialogue::patience(Phase phase, int baud) const {
  if (phase == Phase::finding) return kAckPatience + line_time(20, baud);
  if (phase == Phase::configuring) return kConfigurePatience;
  const bool mode_change = reply_code(phase) == (kSetMode | 0x80);
  return (mode_change ? kModePatience : kReplyPatience) + line_time(200, baud);
}

Dialogue::Answer Dialogue::read(Phase phase, const Event& event) {
  if (event.code() == kRejectedReply) return Answer::refused;
  if (event.code() != reply_code(phase)) return Answer::other;
  return accept(event) ? Answer::accepted : Answer::refused;
}

bool Dialogue::accept(const Event& event) {
  const std::span<const uint8_t> data = event.data();
  switch (event.code()) {
    case kSetMode | 0x80:
      return !data.empty() && data[0] == 0;
    case kSetVariant | 0x80:
      return !data.empty() && data[0] == 1;
    case kGetType | 0x80:
      note_type(data);
      return true;
    case kGetStatus | 0x80: {
      const auto report = decode_status(event);
      defect_ = report && report->defect;
      return true;
    }
    case kGetConfiguration | 0x80: {
      const auto read = decode_configuration(event);
      if (!read) return false;
      wanted_ = *read;
      wanted_.set_measuring(options_.measuring_mode(), options_.value_unit());
      configured_ = wanted_ == *read;
      return true;
    }
    default: {  // kSetConfiguration
      const bool echoed =
          data.size() >= 8 && data[1 + 5] == wanted_.bytes[5] && data[1 + 6] == wanted_.bytes[6];
      return !data.empty() && data[0] == 1 && echoed;
    }
  }
}

Phase Dialogue::next(Phase phase, bool at_goal_baud) const {
  switch (phase) {
    case Phase::finding:
      return at_goal_baud ? Phase::asking_type : Phase::changing_baud;
    case Phase::changing_baud:
      return Phase::settling;
    case Phase::settling:
      return Phase::checking_baud;
    case Phase::checking_baud:
      return Phase::asking_type;
    case Phase::asking_type:
      return Phase::asking_status;
    case Phase::asking_status:
      return Phase::setting_variant;
    case Phase::setting_variant:
      return Phase::reading_configuration;
    case Phase::reading_configuration:
      return configured_ ? Phase::starting : Phase::entering_installation;
    case Phase::entering_installation:
      return Phase::configuring;
    case Phase::configuring:
      return Phase::leaving_installation;
    case Phase::leaving_installation:
      return Phase::starting;
    default:
      return Phase::measuring;
  }
}

}  // namespace marco::drivers::sick
