#include "drivers/ydlidar/answer_parser.hpp"

#include <algorithm>
#include <utility>

#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::ydlidar {
namespace {

constexpr std::size_t kStampSize = 8;
constexpr int kAlikeToTrust = 4;
constexpr int kMisfitsToDoubt = 8;

bool is_known_reply(std::size_t length, uint8_t kind) {
  if (kind == kHealth) return length == kHealthSize;
  return kind == kInfo && (length == kInfoSize || length == 4 || length == 1);
}

}  // namespace

void AnswerParser::clear() {
  unread_.clear();
  continuous_ = false;
  form_.reset();
  alike_ = misfits_ = 0;
}

std::optional<Answer> AnswerParser::next() {
  while (rest().size() >= 2) {
    Answer answer;
    Found found = Found::nothing;
    const unsigned mark = get_u16(rest(), 0);
    if (mark == kReplyMark) found = read_reply(answer);
    if (mark == kStampMark) found = read_stamp();
    if (mark == kPacketMark) found = read_packet(answer);
    if (found == Found::answer) return answer;
    if (found == Found::more_needed) return std::nullopt;
    if (found == Found::skipped) continue;
    unread_.skip();
    continuous_ = false;
  }
  return std::nullopt;
}

AnswerParser::Found AnswerParser::read_reply(Answer& answer) {
  const auto bytes = rest();
  if (bytes.size() < kHeaderSize) return Found::more_needed;
  const uint32_t word = get_u16(bytes, 2) | static_cast<uint32_t>(get_u16(bytes, 4)) << 16U;
  const std::size_t length = word & 0x3FFFFFFFU;
  const uint8_t kind = bytes[6];
  if (word >> 30U == 1 && kind == kPackets) {  // the packets that follow speak for themselves
    unread_.take(kHeaderSize);
    continuous_ = false;
    return Found::skipped;
  }
  if (word >> 30U != 0 || !is_known_reply(length, kind)) return Found::nothing;
  if (bytes.size() < kHeaderSize + length) return Found::more_needed;
  const auto data = bytes.subspan(kHeaderSize, length);
  answer.kind = kind;
  answer.data.assign(data.begin(), data.end());
  unread_.take(kHeaderSize + length);
  answer.bytes_after = rest().size();
  return Found::answer;
}

AnswerParser::Found AnswerParser::read_stamp() {
  const auto bytes = rest();
  if (bytes.size() < kStampSize) return Found::more_needed;
  uint8_t sum = 0;
  for (const uint8_t byte : bytes.first(kStampSize)) sum = static_cast<uint8_t>(sum ^ byte);
  if (sum != 0) return Found::nothing;
  unread_.take(kStampSize);
  return Found::skipped;
}

AnswerParser::Found AnswerParser::read_packet(Answer& answer) {
  if (rest().size() < kPacketHeadSize) return Found::more_needed;
  if (!packet_size(rest(), SampleForm::range)) return Found::nothing;
  Found found = Found::nothing;
  for (const SampleForm form :
       {SampleForm::range, SampleForm::intensity, SampleForm::wide_intensity}) {
    if (form_ && form != *form_) continue;
    found = read_packet_as(form, answer);
    if (found != Found::nothing) break;
  }
  if (found != Found::nothing) return found;
  ++bad_checksums_;
  if (++misfits_ >= kMisfitsToDoubt) form_.reset();
  return found;
}

AnswerParser::Found AnswerParser::read_packet_as(SampleForm form, Answer& answer) {
  const auto bytes = rest();
  const std::size_t size = *packet_size(bytes, form);
  if (bytes.size() < size) return Found::more_needed;
  const auto packet = decode_packet(bytes.first(size), form);
  if (!packet) return Found::nothing;
  answer.kind = kPackets;
  answer.packet = *packet;
  answer.form = form;
  answer.size = size;
  answer.continuous = std::exchange(continuous_, true);
  unread_.take(size);
  answer.bytes_after = rest().size();
  misfits_ = 0;
  count_form(answer);
  return Found::answer;
}

// A packet of zeros fits every form: what counts is that the next one begins where it ends.
void AnswerParser::count_form(const Answer& answer) {
  alike_ = answer.continuous && answer.form == form_before_ ? alike_ + 1 : 0;
  form_before_ = answer.form;
  if (alike_ >= kAlikeToTrust) form_ = answer.form;
}

}  // namespace marco::drivers::ydlidar
