#pragma once

#include <optional>

#include "drivers/transport/unread_bytes.hpp"
#include "drivers/ydlidar/codec.hpp"

namespace marco::drivers::ydlidar {

/// A reply, or a packet with a right checksum.
struct Answer {
  uint8_t kind = 0;  ///< kInfo, kHealth: data; kPackets: packet
  Bytes data;        ///< of 1, 3, 4 or 20 bytes
  Packet packet;
  SampleForm form = SampleForm::range;  ///< of the packet's samples
  std::size_t size = 0;                 ///< bytes of the whole packet
  bool continuous = true;               ///< no bytes were skipped since the packet before
  std::size_t bytes_after = 0;          ///< pushed already, behind it
};

/// Finds replies and packets however they are split, and again after damage. Nobody says how
/// samples are written: the form whose checksum fits is taken.
class AnswerParser : public UnreadParser {
 public:
  std::optional<Answer> next();
  /// Forgets what waits, and the form.
  void clear();

  int64_t bad_checksums() const { return bad_checksums_; }

 private:
  enum class Found { answer, skipped, more_needed, nothing };

  Found read_reply(Answer& answer);
  Found read_stamp();
  Found read_packet(Answer& answer);
  Found read_packet_as(SampleForm form, Answer& answer);
  void count_form(const Answer& answer);

  bool continuous_ = true;
  std::optional<SampleForm> form_;  ///< once some packets in a row had it
  SampleForm form_before_ = SampleForm::range;
  int alike_ = 0;    ///< packets in a row of form_before_
  int misfits_ = 0;  ///< packets in a row whose checksum was wrong
  int64_t bad_checksums_ = 0;
};

}  // namespace marco::drivers::ydlidar
