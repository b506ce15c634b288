#include "drivers/leuze/connection_per_request.hpp"

#include <thread>

namespace marco::drivers::leuze {

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

}  // namespace marco::drivers::leuze
