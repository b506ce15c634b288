#include "drivers/cola/driver.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"
#include "drivers/laser/laser_state.hpp"

namespace marco::drivers::cola {
namespace {

constexpr uint16_t kLeastRange = 16;  // below: no echo, or a code
constexpr double kDegPerE4 = 1e-4;

/// Whether the angles of a channel lie within a turn and its beams have some order in time.
bool is_measurable(const Channel& ranges, uint32_t rate_chz) {
  const double span_deg =
      kDegPerE4 * std::abs(ranges.step_e4) * static_cast<double>(ranges.values.size());
  return ranges.values.size() > 1 && ranges.step_e4 != 0 && span_deg <= 361.0 && rate_chz > 0 &&
         ranges.scale > 0.0;
}

constexpr Duration kPatience = Duration::from_us(500'000);
// A laser that was logged in measures again only some time after.
constexpr double kStartS = 3.0;
constexpr int kTries = 3;
// "sRN SCdevicestate" in CoLa B: only a laser that is set to it answers.
constexpr uint8_t kBinaryQuestion[] = {2,   2,   2,   2,   0,   0,   0,   17,  's',
                                       'R', 'N', ' ', 'S', 'C', 'd', 'e', 'v', 'i',
                                       'c', 'e', 's', 't', 'a', 't', 'e', 0x30};

bool answers_to(const std::string& text, const std::string& request) {
  // "sRN Name" is answered by "sRA Name ...", a method "sMN Name" by "sAN Name ...".
  std::string answer = request.substr(0, request.find(' ', 4));
  if (answer[1] == 'M') {
    answer.replace(1, 2, "AN");
  } else {
    answer[2] = 'A';
  }
  return text.starts_with(answer);
}

}  // namespace

void ScanAssembler::restart_clock() {
  filter_.reset();
  sent_us_.reset();
  device_s_ = 0.0;
}

const char* ScanAssembler::trouble() const {
  if ((status_ & 1U) != 0 && (status_ & 4U) == 0) return "the laser reports an error";
  return status_ != 0 ? "the laser's window is dirty: wipe it" : "";
}

double ScanAssembler::unwrapped_s(uint32_t sent_us) {
  device_s_ += 1e-6 * static_cast<double>(sent_us - sent_us_.value_or(sent_us));
  sent_us_ = sent_us;
  return device_s_;
}

void ScanAssembler::add(const ScanData& data, Utime arrival) {
  const Channel* ranges = data.channel("DIST1");
  if (ranges == nullptr || !is_measurable(*ranges, data.rate_chz)) {
    ++counts_.drops["inconsistent"];
    return;
  }
  ++counts_.scans;
  status_ = data.status;
  scan_period_s_ = 100.0 / data.rate_chz;
  const double beam_s = scan_period_s_ * kDegPerE4 * std::abs(ranges->step_e4) / 360.0;
  scan_duration_s_ = beam_s * static_cast<double>(ranges->values.size() - 1);
  const Utime sent = filter_.update(unwrapped_s(data.sent_us), arrival);
  // No scan is sent before its last beam was measured, whatever the stamps say.
  const double since_begin_s = 1e-6 * static_cast<double>(data.sent_us - data.begin_us);
  const bool likely = since_begin_s < scan_duration_s_ + 10.0 * scan_period_s_;

  ArrivedScan arrived;
  arrived.arrival = arrival;
  LaserScan& scan = arrived.scan;
  scan.utime = sent - Duration::from_seconds(likely ? std::max(since_begin_s, scan_duration_s_)
                                                    : scan_duration_s_);
  scan.first_bearing_rad = deg_to_rad(kDegPerE4 * ranges->start_e4 - kAheadDeg);
  scan.bearing_step_rad = deg_to_rad(kDegPerE4 * ranges->step_e4);
  for (std::size_t i = 0; i < ranges->values.size(); ++i) {
    const bool echo = ranges->values[i] >= kLeastRange;
    scan.ranges_m.push_back(echo ? static_cast<float>(1e-3 * ranges->scaled(i)) : 0.0F);
    scan.time_offsets_s.push_back(static_cast<float>(beam_s * static_cast<double>(i)));
  }
  const Channel* intensities = data.channel("RSSI1");
  for (std::size_t i = 0; intensities != nullptr && i < intensities->values.size(); ++i) {
    arrived.intensities.push_back(static_cast<float>(intensities->scaled(i)));
  }
  ready_.push_back(std::move(arrived));
}

ColaDriver::ColaDriver(ByteStream& stream, const ColaOptions& options, Clock clock)
    : Dialogue(stream, std::move(clock)), options_(options) {
  validate(options, "cola");
  enter(Phase::finding);
}

LaserProperties ColaDriver::properties() const {
  return {scans_.scan_duration_s(), options_.range_min_m,
          options_.range_max_m > 0.0 ? options_.range_max_m : range_max_of(model_),
          options_.range_sigma_m};
}

std::string ColaDriver::request_of(Phase phase) {
  switch (phase) {
    case Phase::waiting:
      return "sRN SCdevicestate";
    case Phase::logging_in:
      return "sMN SetAccessMode 03 F4724744";  // "authorized client", with the maker's password
    case Phase::asking_intensities:
      return "sWN LMDscandatacfg 01 00 1 1 0 00 00 0 0 0 0 +1";
    case Phase::asking_short_intensities:
      return "sWN LMDscandatacfg 01 00 1 0 0 00 00 0 0 0 0 +1";
    case Phase::logging_out:
      return "sMN Run";
    case Phase::starting:
      return "sEN LMDscandata 1";
    default:
      return "sRN DeviceIdent";
  }
}

void ColaDriver::enter(Phase phase) {
  phase_ = phase;
  tries_ = 0;
  if (phase != Phase::measuring) return ask();
  scans_.restart_clock();
  wait(Duration::from_seconds(kStartS));
  trouble_.clear();
}

void ColaDriver::ask() {
  ++tries_;
  send(request_of(phase_));
  wait(kPatience);
}

void ColaDriver::send(const std::string& text) { stream_.write(encode_telegram(text)); }

void ColaDriver::start_over(const std::string& why) {
  trouble_ = why;
  parser_.clear();
  enter(Phase::finding);
}

Duration ColaDriver::silence_allowed() const {
  return Duration::from_seconds(0.5 + 3.0 * scans_.scan_period_s());
}

void ColaDriver::on_input_flushed() {
  parser_.clear();
  if (phase_ == Phase::measuring) wait(silence_allowed());
}

void ColaDriver::on_timeout() {
  if (phase_ == Phase::measuring) return start_over("the scans stopped");
  if (phase_ != Phase::finding) {
    return tries_ < kTries ? ask() : start_over("the laser stopped answering");
  }
  if (parser_.heard_binary()) {
    trouble_ = "it speaks CoLa B, the binary dialect: set CoLa A in SICK's SOPAS ET";
  } else if (tries_ % kTries == 0) {
    stream_.write(kBinaryQuestion);
  }
  ask();
}

void ColaDriver::on_answer(const Telegram& telegram, Utime arrival) {
  const std::string& text = telegram.text;
  if (text.starts_with("sSN LMDscandata")) return on_scan(text, arrival);
  if (phase_ == Phase::measuring) return;
  if (refusal(text) || answers_to(text, request_of(phase_))) on_reply(text);
}

void ColaDriver::on_scan(const std::string& text, Utime arrival) {
  // A laser that was left measuring: its scans come before the answers.
  if (phase_ != Phase::measuring) return;
  const auto data = decode_scan(text);
  if (!data) {
    ++scans_.counts().drops["inconsistent"];
    return;
  }
  scans_.add(*data, arrival);
  deadline_ = arrival + silence_allowed();
}

void ColaDriver::on_reply(const std::string& text) {
  const auto refused = refusal(text);
  switch (phase_) {
    case Phase::finding:
      model_ = refused ? "" : model_of(text);
      return enter(Phase::waiting);
    case Phase::waiting:
      return on_state(text);
    case Phase::logging_in:  // a TiM561 says no and takes the settings all the same
      return enter(Phase::asking_intensities);
    case Phase::asking_intensities:
      return enter(refused ? Phase::asking_short_intensities : Phase::logging_out);
    case Phase::asking_short_intensities:
    case Phase::logging_out:
      return enter(phase_ == Phase::logging_out ? Phase::starting : Phase::logging_out);
    default:
      if (refused) return start_over("the laser refused to measure: " + text);
      return enter(Phase::measuring);
  }
}

// "sRA SCdevicestate 1": 0 busy, 1 ready, 2 error. A laser that does not know the question is
// ready.
void ColaDriver::on_state(const std::string& text) {
  if (!refusal(text) && !text.ends_with(" 1")) {
    trouble_ = text.ends_with(" 2") ? "the laser reports an error" : "the laser is not ready yet";
    tries_ = 0;
    return;  // asked again when the time is up
  }
  trouble_.clear();
  enter(options_.intensities ? Phase::logging_in : Phase::starting);
}

std::string ColaDriver::state() const {
  std::string state = "setting the laser up, step " + std::to_string(static_cast<int>(phase_));
  if (phase_ == Phase::finding) state = "looking for the laser";
  if (phase_ == Phase::measuring) {
    state = "measuring, " + describe_scans(counts(), scans_.filter()) +
            (model_.empty() ? "" : ", " + model_);
  }
  const std::string said = phase_ == Phase::measuring ? scans_.trouble() : trouble_;
  return with_trouble(state, counts(), said.empty() ? trouble_ : said);
}

}  // namespace marco::drivers::cola
