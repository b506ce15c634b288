#include "drivers/leuze/driver.hpp"

#include <algorithm>
#include <utility>

#include "drivers/laser/laser_state.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::leuze {
namespace {

constexpr std::chrono::microseconds kStep{50'000};
constexpr Duration kPatience = Duration::from_us(300'000);
constexpr Duration kLook = Duration::from_us(600'000);
constexpr std::size_t kTwoTelegrams = 2400;  // bytes, of the most beams

}  // namespace

SpeedSearch::SpeedSearch(int wanted) : rates_{wanted} {
  for (const int rate : {57'600, 115'200, 38'400, 19'200, 9600}) {
    if (wanted != 0 && rate != wanted) rates_.push_back(rate);
  }
}

void SpeedSearch::next(bool lost) {
  const bool bytes_came = std::exchange(any_byte_, false);
  if (lost) return;
  if (!understood_) {
    rate_ = (rate_ + 1) % rates_.size();
    return;
  }
  if (rate_ != *understood_ || !bytes_came) {
    rate_ = *understood_;
    return;
  }
  other_ = (other_ + 1) % rates_.size();
  if (other_ == *understood_) other_ = (other_ + 1) % rates_.size();
  rate_ = other_;
}

LeuzeDriver::LeuzeDriver(ByteStream& stream, const LeuzeOptions& options, Clock clock)
    : stream_(stream), options_(options), clock_(std::move(clock)), search_(options.baud) {
  validate(options, "leuze");
  listen();
}

void LeuzeDriver::listen() {
  const int baud = search_.current();
  measuring_ = false;
  if (baud != 0) stream_.set_line({baud, Parity::none});
  stream_.discard_input();
  parser_.clear();
  scan_clock_.reset();
  const Duration whole = kPatience + line_time(kTwoTelegrams, baud);
  deadline_ = clock_() + (search_.exploring() ? std::min(whole, kLook) : whole);
}

std::vector<ArrivedScan> LeuzeDriver::step() {
  uint8_t buffer[4096];
  const std::size_t count = stream_.read(buffer, kStep);
  const Utime arrival = clock_();
  parser_.push({buffer, count});
  while (const auto telegram = parser_.next()) on_telegram(*telegram, arrival);
  if (count > 0) search_.on_bytes();
  counts_.garbage_bytes = parser_.garbage_bytes();
  if (parser_.bad_checksums() > 0) counts_.drops["bad_checksum"] = parser_.bad_checksums();
  if (clock_() >= deadline_) {
    search_.next(measuring_);
    listen();
  }
  return std::exchange(ready_, {});
}

void LeuzeDriver::on_input_flushed() {
  parser_.clear();
  scan_clock_.reset();
  deadline_ = std::max(deadline_, clock_() + kPatience);
}

void LeuzeDriver::on_telegram(const Telegram& telegram, Utime arrival) {
  const int baud = search_.current();
  measuring_ = true;
  search_.on_telegram();
  deadline_ = clock_() + kPatience + line_time(kTwoTelegrams, baud);
  complaint_.clear();
  if (telegram.operation == kWarning) complaint_ = "warning";
  if (telegram.operation == kError || (telegram.options[0] & kErrorBit) != 0) {
    complaint_ = "the laser reports an error";
  }
  if (telegram.operation != kMeasurement) return;
  ++counts_.scans;
  const std::size_t bytes = encode_telegram(telegram).size() + parser_.bytes_after();
  const Utime end = scan_clock_.update(arrival - line_time(bytes, baud), parser_.bad_checksums());
  const double first_beam_s = (telegram.first - 1) * options_.geometry.beam_interval_s();
  std::vector<double> ranges_m;
  for (const uint16_t value_mm : telegram.values_mm) ranges_m.push_back(value_mm * 0.001);
  ready_.push_back({options_.scan_of(ranges_m, telegram.first, telegram.step,
                                     end - Duration::from_seconds(kSweepS - first_beam_s)),
                    arrival});
}

std::string LeuzeDriver::state() const {
  return with_trouble(measuring_ ? "measuring, " + describe_scans(counts_, scan_clock_.filter())
                                 : "waiting for the laser's telegrams, at " +
                                       std::to_string(search_.current()) + " baud",
                      counts_, complaint_);
}

}  // namespace marco::drivers::leuze
