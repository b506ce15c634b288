#include "drivers/hcs12/line_exchange.hpp"

#include <utility>

namespace marco::drivers::hcs12 {

void LineExchange::on_connection(bool connected, Utime now) {
  connected_ = connected;
  clear();
  timeouts_in_a_row_ = 0;
  next_ping_ = now;
}

void LineExchange::ping_later(Utime now) {
  constexpr double kPingS = 0.5;
  next_ping_ = now + Duration::from_seconds(kPingS);
}

bool LineExchange::ping_due(Utime now) {
  if (now < next_ping_ || !quiet()) return false;
  ping_later(now);
  return true;
}

void LineExchange::clear() {
  queue_.clear();
  outstanding_.reset();
  cutter_.clear();
}

std::vector<std::string> LineExchange::receive(std::span<const uint8_t> bytes) {
  std::vector<std::string> lines;
  for (const uint8_t byte : bytes) {
    if (auto line = cutter_.push(byte)) lines.push_back(std::move(*line));
  }
  return lines;
}

std::optional<LineExchange::Request> LineExchange::advance(Utime now, std::vector<uint8_t>& out) {
  std::optional<Request> late;
  if (outstanding_ && (now - sent_).seconds() > outstanding_->patience_s) {
    late = std::exchange(outstanding_, std::nullopt);
  }
  if (outstanding_ || queue_.empty() || late) return late;
  Request request = std::move(queue_.front());
  queue_.pop_front();
  out.insert(out.end(), request.line.begin(), request.line.end());
  // The board has the line when its bytes have left; only then does its time run.
  sent_ = now + Duration::from_us(
                    static_cast<int64_t>(kByteUs * static_cast<double>(request.line.size())));
  if (request.reply != '\0') outstanding_ = std::move(request);
  return late;
}

}  // namespace marco::drivers::hcs12
