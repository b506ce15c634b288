#include "drivers/leuze/driver.hpp"

#include <algorithm>
#include <cstdio>
#include <thread>
#include <utility>

#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::leuze {
namespace {

using std::chrono::microseconds;
constexpr microseconds kStep{50'000};
constexpr Duration kPatience = Duration::from_us(300'000);
constexpr Duration kLook = Duration::from_us(600'000);
constexpr Duration kServicePatience = Duration::from_us(1'000'000);

LaserSight sight_of(const LeuzeOptions& options) {
  return {528 * options.geometry.beam_interval_s(), options.range_min_m, options.range_max_m,
          options.range_sigma_m};
}

ArrivedScan scan_of(const LeuzeOptions& options, int first, int step, Utime utime, Utime arrival) {
  ArrivedScan arrived;
  arrived.arrival = arrival;
  arrived.scan.utime = utime;
  arrived.scan.first_bearing_rad = options.geometry.bearing_rad(first);
  arrived.scan.bearing_step_rad = step * options.geometry.step_rad();
  return arrived;
}

}  // namespace

LeuzeDriver::LeuzeDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock)
    : stream_(stream), options_(options), clock_(std::move(clock)), rates_{options.baud} {
  validate(options, "leuze");
  for (const int rate : {57'600, 115'200, 38'400, 19'200, 9600}) {
    if (options.baud != 0 && rate != options.baud) rates_.push_back(rate);
  }
  listen_at(0);
}

void LeuzeDriver::listen_at(std::size_t rate) {
  rate_ = rate % rates_.size();
  measuring_ = false;
  if (rates_[rate_] != 0) stream_.set_line({rates_[rate_], Parity::none});
  stream_.discard_input();
  parser_.clear();
  turns_.reset();
  filter_.reset();
  heard_ = false;
  // Long enough for two telegrams of the most beams; where it was never heard, only for a look.
  const Duration whole = kPatience + line_time(2400, rates_[rate_]);
  deadline_ = clock_() + (good_rate_ && *good_rate_ != rate_ ? std::min(whole, kLook) : whole);
}

void LeuzeDriver::listen_on() {
  if (measuring_) return listen_at(rate_);
  if (!good_rate_) return listen_at(rate_ + 1);
  // A laser that was heard has most likely kept its speed: it is listened for there, always while
  // the line is quiet, else every other time.
  if (rate_ != *good_rate_ || !heard_) return listen_at(*good_rate_);
  other_ = (other_ + 1) % rates_.size();
  if (other_ == *good_rate_) other_ = (other_ + 1) % rates_.size();
  listen_at(other_);
}

LaserSight LeuzeDriver::sight() const { return sight_of(options_); }

std::vector<ArrivedScan> LeuzeDriver::step() {
  uint8_t buffer[4096];
  const std::size_t count = stream_.read(buffer, kStep);
  const Utime arrival = clock_();
  parser_.push({buffer, count});
  while (const auto telegram = parser_.next()) on_telegram(*telegram, arrival);
  heard_ = heard_ || count > 0;
  if (clock_() >= deadline_) listen_on();
  counts_.garbage_bytes = parser_.garbage_bytes();
  if (parser_.bad_checksums() > 0) counts_.drops["bad_checksum"] = parser_.bad_checksums();
  return std::exchange(ready_, {});
}

void LeuzeDriver::on_line_emptied() {
  parser_.clear();
  turns_.reset();
  filter_.reset();
  deadline_ = std::max(deadline_, clock_() + kPatience);
}

void LeuzeDriver::on_telegram(const Telegram& telegram, Utime arrival) {
  const int baud = rates_[rate_];
  measuring_ = true;
  good_rate_ = rate_;
  deadline_ = clock_() + kPatience + line_time(2400, baud);
  if (telegram.operation != kMeasurement) {
    complaint_ = telegram.operation == kError ? "the laser reports an error" : "warning";
    return;
  }
  complaint_.clear();
  if ((telegram.options[0] & kErrorBit) != 0) complaint_ = "the laser reports an error";
  ++counts_.scans;
  const Utime end =
      arrival - line_time(encode_telegram(telegram).size() + parser_.bytes_after(), baud);
  const bool lost = std::exchange(bad_before_, parser_.bad_checksums()) != parser_.bad_checksums();
  const double swept_s = turns_.update(end, lost ? TurnCounter::Gap::any : TurnCounter::Gap::none);
  const Utime filtered = filter_.update(swept_s, end);
  ArrivedScan arrived =
      scan_of(options_, telegram.first, telegram.step,
              filtered - Duration::from_seconds(kSweepS - (telegram.first - 1) *
                                                              options_.geometry.beam_interval_s()),
              arrival);
  for (const uint16_t value_mm : telegram.values_mm) {
    arrived.scan.ranges_m.push_back(static_cast<float>(value_mm * 0.001 * options_.geometry.scale));
  }
  ready_.push_back(std::move(arrived));
}

std::string LeuzeDriver::state() const {
  char text[120];
  if (measuring_) {
    std::snprintf(text, sizeof(text), "measuring, %lld scans, jitter %.2f ms, max %.2f ms",
                  static_cast<long long>(counts_.scans), filter_.jitter_s() * 1e3,
                  filter_.max_delay_s() * 1e3);
  } else {
    std::snprintf(text, sizeof(text), "waiting for the laser's telegrams, at %d baud",
                  rates_[rate_]);
  }
  std::string line = text;
  if (counts_.garbage_bytes > 0) line += ", garbage bytes " + std::to_string(counts_.garbage_bytes);
  if (!complaint_.empty()) line += ", " + complaint_;
  return line;
}

// ---- the service -------------------------------------------------------------------------------

std::size_t ConnectionPerRequest::read(std::span<uint8_t> into, microseconds timeout) {
  if (connection_) return connection_->read(into, timeout);
  std::this_thread::sleep_for(timeout);
  return 0;
}

void ConnectionPerRequest::write(std::span<const uint8_t> bytes) {
  connection_.reset();
  connection_ = connect_();
  connection_->write(bytes);
}

LeuzeServiceDriver::LeuzeServiceDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock)
    : stream_(stream), options_(options), clock_(std::move(clock)) {
  validate(options, "leuze");
}

LaserSight LeuzeServiceDriver::sight() const { return sight_of(options_); }

void LeuzeServiceDriver::on_line_emptied() {
  answer_.clear();
  waiting_ = false;
}

std::vector<ArrivedScan> LeuzeServiceDriver::step() {
  if (!waiting_ && clock_() >= next_request_) {
    answer_.clear();
    stream_.write(service_request());
    waiting_ = true;
    next_request_ = clock_() + Duration::from_seconds(options_.poll_s);
    deadline_ = clock_() + kServicePatience;
  }
  const Utime until = waiting_ ? deadline_ : next_request_;
  const microseconds wait = std::clamp(microseconds((until - clock_()).us), microseconds(0), kStep);
  uint8_t buffer[1024];
  const std::size_t count = stream_.read(buffer, wait);
  const Utime arrival = clock_();
  answer_.insert(answer_.end(), buffer, buffer + count);
  if (!waiting_) return {};
  if (answer_.size() < 4 * kServiceBeams) {
    if (arrival >= deadline_) {
      ++counts_.drops["no_answer"];
      waiting_ = false;
      stream_.discard_input();
    }
    return {};
  }
  waiting_ = false;
  stream_.discard_input();
  const auto ranges = decode_service_answer(answer_);
  if (!ranges) {
    ++counts_.drops["inconsistent"];
    return {};
  }
  ++counts_.scans;
  ArrivedScan arrived =
      scan_of(options_, 1, 4, arrival - Duration::from_seconds(1.5 * kSweepS), arrival);
  for (const float range : *ranges) {
    arrived.scan.ranges_m.push_back(range * static_cast<float>(options_.geometry.scale));
  }
  std::vector<ArrivedScan> one;
  one.push_back(std::move(arrived));
  return one;
}

std::string LeuzeServiceDriver::state() const {
  return (counts_.scans > 0 ? "measuring, " : "asking the service, ") +
         std::to_string(counts_.scans) + " scans";
}

}  // namespace marco::drivers::leuze
