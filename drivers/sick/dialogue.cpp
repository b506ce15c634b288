// What the driver asks in each phase, how it reads the answers, and which phase comes next.
#include "drivers/sick/driver.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::sick {
namespace {

constexpr Duration kAckPatience = Duration::from_us(120'000);  // the device's promise: 60 ms
constexpr Duration kReplyPatience = Duration::from_us(1'000'000);
constexpr Duration kConfigurePatience = Duration::from_us(15'000'000);

}  // namespace

Bytes SickDriver::request_of(Phase phase) const {
  switch (phase) {
    case Phase::changing_baud:
      return set_mode_request(*mode_of_baud(goal_baud_));
    case Phase::asking_type:
      return encode_request(Bytes{kGetType});
    case Phase::checking_baud:
    case Phase::asking_status:
      return encode_request(Bytes{kGetStatus});
    case Phase::setting_variant:
      return set_variant_request(options_.angle_deg, resolution_cdeg());
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

uint8_t SickDriver::reply_code_of(Phase phase) const {
  return static_cast<uint8_t>(request_of(phase)[4] | 0x80);
}

Duration SickDriver::patience_of(Phase phase) const {
  if (phase == Phase::finding) return kAckPatience + line_time(20, baud_);
  if (phase == Phase::configuring) return kConfigurePatience;
  const bool mode_change = reply_code_of(phase) == (kSetMode | 0x80);
  return (mode_change ? kModePatience : kReplyPatience) + line_time(200, baud_);
}

SickDriver::Answer SickDriver::read_reply(const Event& event) {
  const std::span<const uint8_t> data = event.data();
  const auto answer = [](bool good) { return good ? Answer::good : Answer::refused; };
  switch (event.code()) {
    case kSetMode | 0x80:
      return answer(!data.empty() && data[0] == 0);
    case kSetVariant | 0x80:
      return answer(!data.empty() && data[0] == 1);
    case kGetType | 0x80:
      type_.assign(data.begin(), data.end());
      return Answer::good;
    case kGetStatus | 0x80: {
      const auto report = decode_status(event);
      if (report && report->defect) trouble_ = "the laser reports a defect";
      return Answer::good;
    }
    case kGetConfiguration | 0x80: {
      const auto read = decode_configuration(event);
      if (!read) return Answer::refused;
      wanted_ = *read;
      wanted_.set_measuring(measuring_mode_, unit_);
      configured_ = wanted_ == *read;
      return Answer::good;
    }
    case kSetConfiguration | 0x80: {
      const bool echoed =
          data.size() >= 8 && data[1 + 5] == wanted_.bytes[5] && data[1 + 6] == wanted_.bytes[6];
      return answer(!data.empty() && data[0] == 1 && echoed);
    }
    default:
      return Answer::good;
  }
}

SickDriver::Phase SickDriver::phase_after(Phase phase) const {
  switch (phase) {
    case Phase::finding:
      return baud_ == goal_baud_ ? Phase::asking_type : Phase::changing_baud;
    case Phase::changing_baud:
      return Phase::settling;
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
