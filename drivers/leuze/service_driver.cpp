#include "drivers/leuze/service_driver.hpp"

#include <algorithm>
#include <thread>
#include <utility>

namespace marco::drivers::leuze {
namespace {

using std::chrono::microseconds;
constexpr microseconds kReadTimeout{50'000};
constexpr Duration kServicePatience = Duration::from_us(1'000'000);

}  // namespace

std::size_t ConnectionPerRequest::read(std::span<uint8_t> into, std::chrono::microseconds timeout) {
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

void LeuzeServiceDriver::on_input_flushed() {
  answer_.clear();
  waiting_ = false;
}

void LeuzeServiceDriver::end_request() {
  waiting_ = false;
  stream_.discard_input();
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
  const microseconds wait =
      std::clamp(microseconds((until - clock_()).us), microseconds(0), kReadTimeout);
  uint8_t buffer[1024];
  const std::size_t count = stream_.read(buffer, wait);
  const Utime arrival = clock_();
  answer_.insert(answer_.end(), buffer, buffer + count);
  if (!waiting_) return {};
  if (answer_.size() < kServiceBytes) {
    if (arrival < deadline_) return {};
    ++counts_.drops["no_answer"];
    end_request();
    return {};
  }
  end_request();
  const auto ranges = decode_service_answer(answer_);
  if (!ranges) {
    ++counts_.drops["inconsistent"];
    return {};
  }
  ++counts_.scans;
  return {
      {options_.scan_of(*ranges, 1, kServiceStep, arrival - Duration::from_seconds(1.5 * kSweepS)),
       arrival}};
}

std::string LeuzeServiceDriver::state() const {
  return (counts_.scans > 0 ? "measuring, " : "asking the service, ") +
         std::to_string(counts_.scans) + " scans";
}

}  // namespace marco::drivers::leuze
