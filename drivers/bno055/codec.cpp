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

std::optional<Request> RequestParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    if (rest[0] != kRequest || (rest.size() > 1 && rest[1] > kRead) ||
        (rest.size() >= kHead && (rest[3] == 0 || rest[3] > kMostBytes))) {
      unread_.skip();
      continue;
    }
    if (rest.size() < kHead) return std::nullopt;
    Request request{rest[1] == kWrite, rest[2], rest[3], {}};
    const std::size_t size = kHead + (request.write ? request.count : 0);
    if (rest.size() < size) return std::nullopt;
    const auto data = rest.subspan(kHead, size - kHead);
    request.data.assign(data.begin(), data.end());
    unread_.take(size);
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
  unread_.clear();
  count_ = count;
}

std::optional<Reply> ReplyParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    const bool status = rest[0] == kStatus;
    const bool data = count_ > 0 && rest[0] == kData;
    const bool begins = (status && (rest.size() < 2 || rest[1] <= 0x0A)) ||
                        (data && (rest.size() < 2 || rest[1] == count_));
    if (!begins) {
      unread_.skip();
      continue;
    }
    const std::size_t size = status ? 2 : 2 + count_;
    if (rest.size() < size) return std::nullopt;
    Reply reply;
    if (status) {
      reply.status = rest[1];
    } else {
      reply.data.assign(rest.begin() + 2, rest.begin() + static_cast<std::ptrdiff_t>(size));
    }
    unread_.take(size);
    return reply;
  }
  return std::nullopt;
}

}  // namespace marco::drivers::bno055
