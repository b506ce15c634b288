#include "drivers/bno055/codec.hpp"

#include "lcm_tools/base/check.hpp"

namespace marco::drivers::bno055 {
namespace {

constexpr uint8_t kRequest = 0xAA, kWrite = 0x00, kRead = 0x01;
constexpr uint8_t kData = 0xBB, kStatus = 0xEE;
constexpr std::size_t kHead = 4;

}  // namespace

Bytes read_request(Register first, std::size_t count) {
  require(count > 0 && count <= kMostBytes, "1 to 128 registers are read at once");
  return {kRequest, kRead, static_cast<uint8_t>(first), static_cast<uint8_t>(count)};
}

Bytes write_request(Register which, uint8_t value) {
  return {kRequest, kWrite, static_cast<uint8_t>(which), 1, value};
}

void RequestParser::push(std::span<const uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Request> RequestParser::next() {
  const auto drop = [this](std::size_t count) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
  };
  while (!buffer_.empty()) {
    if (buffer_[0] != kRequest || (buffer_.size() > 1 && buffer_[1] > kRead) ||
        (buffer_.size() >= kHead && (buffer_[3] == 0 || buffer_[3] > kMostBytes))) {
      drop(1);
      continue;
    }
    if (buffer_.size() < kHead) return std::nullopt;
    Request request{buffer_[1] == kWrite, buffer_[2], buffer_[3], {}};
    const std::size_t size = kHead + (request.write ? request.count : 0);
    if (buffer_.size() < size) return std::nullopt;
    request.data.assign(buffer_.begin() + kHead,
                        buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    drop(size);
    return request;
  }
  return std::nullopt;
}

Bytes data_reply(std::span<const uint8_t> data) {
  Bytes reply{kData, static_cast<uint8_t>(data.size())};
  reply.insert(reply.end(), data.begin(), data.end());
  return reply;
}

Bytes status_reply(uint8_t code) { return {kStatus, code}; }

void ReplyParser::expect(std::size_t count) {
  buffer_.clear();
  count_ = count;
}

void ReplyParser::push(std::span<const uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Reply> ReplyParser::next() {
  while (!buffer_.empty()) {
    const bool status = buffer_[0] == kStatus;
    const bool data = count_ > 0 && buffer_[0] == kData;
    const bool begins = (status && (buffer_.size() < 2 || buffer_[1] <= 0x0A)) ||
                        (data && (buffer_.size() < 2 || buffer_[1] == count_));
    if (!begins) {
      buffer_.erase(buffer_.begin());
      ++garbage_bytes_;
      continue;
    }
    const std::size_t size = status ? 2 : 2 + count_;
    if (buffer_.size() < size) return std::nullopt;
    Reply reply;
    if (status) {
      reply.status = buffer_[1];
    } else {
      reply.data.assign(buffer_.begin() + 2, buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    }
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    return reply;
  }
  return std::nullopt;
}

}  // namespace marco::drivers::bno055
