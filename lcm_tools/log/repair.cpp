#include "lcm_tools/log/repair.hpp"

#include <algorithm>
#include <optional>

#include "lcm_tools/log/event_sequence.hpp"
#include "lcm_tools/log/piece_copier.hpp"
#include "lcm_tools/log/restore.hpp"
#include "lcm_tools/schema/schema.hpp"

namespace marco::logs {
namespace {

constexpr int64_t kHeaderBytes = 28;
constexpr std::size_t kListed = 1000;

struct Event {
  int64_t offset = 0;  // of the header, in the damaged log
  int64_t end = 0;
  int64_t number = 0;
  Utime event_time;
  std::string channel;
  int64_t data_bytes = 0;
  uint64_t fingerprint = 0;
  std::vector<const char*> mended;
};

class Repair {
 public:
  Repair(const std::filesystem::path& in, OutputFile& out, Mending mending, const Decodes& decodes)
      : in_(in),
        out_(out),
        mending_(mending),
        decodes_(decodes),
        reader_(in.string()),
        copier_(in, out) {}

  RepairReport run(const OnProgress& on_progress) {
    if (mending_ == Mending::headers) learn(on_progress);
    int64_t events = 0;
    int64_t behind = 0;
    while (auto head = reader_.next_head()) {
      if (head->skipped_bytes > 0) {
        // The stretch is looked into with the same reader, whose views end with that.
        const Event next = event_of(*head);
        damaged_stretch(next.offset - head->skipped_bytes, next.offset);
        take(next);
      } else {
        take(event_of(*head));
      }
      behind = reader_.position_bytes();
      if (++events % 4096 == 0) on_progress(0.4 + 0.6 * part_done());
    }
    if (behind < reader_.size_bytes()) damaged_stretch(behind, reader_.size_bytes());
    if (pending_) write(*pending_, nullptr);
    copier_.copy();
    report_.missing_numbers = sequence_.missing_numbers();
    return report_;
  }

 private:
  void learn(const OnProgress& on_progress) {
    files::EventLogReader survey(in_.string());
    int64_t events = 0;
    while (const auto head = survey.next_head()) {
      known_.add(head->channel, lcm_schema::fingerprint_of(head->first_bytes).value_or(0),
                 head->data_bytes);
      if (++events % 4096 == 0) {
        on_progress(0.4 * static_cast<double>(survey.position_bytes()) /
                    static_cast<double>(survey.size_bytes()));
      }
    }
  }
  double part_done() const {
    return static_cast<double>(reader_.position_bytes()) /
           static_cast<double>(reader_.size_bytes());
  }
  static Event event_of(const files::LogEventHead& head) {
    Event event;
    event.offset = head.offset;
    event.end = head.end_offset();
    event.number = head.number;
    event.event_time = head.event_time;
    event.channel = head.channel;
    event.data_bytes = head.data_bytes;
    event.fingerprint = lcm_schema::fingerprint_of(head.first_bytes).value_or(0);
    return event;
  }
  void damaged_stretch(int64_t from, int64_t to) {
    if (!extend_pending(from, to)) recover(from, to);
  }
  bool extend_pending(int64_t from, int64_t to);
  bool is_more_whole(const Event& longer, const Event& shorter);
  // Events with damaged headers between two places where an event begins.
  void recover(int64_t from, int64_t to) {
    while (from < to) {
      Event event;
      event.offset = from;
      event.end = next_begin(from, to);
      const int64_t end = event.end;
      if (mending_ == Mending::headers && read_damaged(event)) {
        take(std::move(event));
      } else {
        lose(from, end);
      }
      from = end;
    }
  }
  bool looks_like_sync(int64_t offset) const {
    std::array<uint8_t, kHeaderBytes> bytes{};
    return reader_.read_at(offset, std::span(bytes).first(4)) &&
           HeaderBytes(bytes.data()).sync_like;
  }
  int64_t next_begin(int64_t from, int64_t to) const;
  bool read_damaged(Event& event);
  bool is_length_believable(const Event& event, bool is_cut_off);
  void lose(int64_t from, int64_t to) {
    const bool goes_on =
        !report_.lost.empty() && report_.lost.back().offset + report_.lost.back().bytes == from;
    report_.lost_bytes += to - from;
    if (goes_on) {
      report_.lost.back().bytes += to - from;
      return;
    }
    ++report_.lost_places;
    if (report_.lost.size() < kListed) report_.lost.push_back({from, to - from});
  }
  // One event is held back until the next one shows whether its number and time are right.
  void take(Event event) {
    if (pending_) write(*pending_, &event);
    pending_ = std::move(event);
  }
  void mend(Event& event, const Event* next);
  void write(Event& event, const Event* next);
  void check_message(const Event& event);

  std::filesystem::path in_;
  OutputFile& out_;
  Mending mending_;
  const Decodes& decodes_;
  files::EventLogReader reader_;
  PieceCopier copier_;
  KnownChannels known_;
  std::optional<Event> pending_;
  EventSequence sequence_;
  std::vector<uint8_t> message_;
  RepairReport report_;
};

// A length damaged to a smaller one leaves the message's end lying between two events.
bool Repair::extend_pending(int64_t from, int64_t to) {
  if (mending_ == Mending::nothing || !pending_ || pending_->end != from) return false;
  if (to - from >= 4 && looks_like_sync(from)) return false;
  Event longer;
  longer.offset = pending_->offset;
  longer.end = to;
  if (!read_damaged(longer)) return false;
  const bool other_channel = longer.channel != pending_->channel &&
                             known_.events(longer.channel) > known_.events(pending_->channel);
  if (!other_channel && !is_more_whole(longer, *pending_)) return false;
  pending_ = longer;
  return true;
}

// Whether the longer reading of a message is the better one.
bool Repair::is_more_whole(const Event& longer, const Event& shorter) {
  if (const auto usual = known_.usual_data_bytes(shorter.channel)) {
    return longer.data_bytes == *usual && shorter.data_bytes != *usual;
  }
  message_.resize(static_cast<std::size_t>(longer.data_bytes));
  if (!reader_.read_at(longer.end - longer.data_bytes, message_)) return false;
  const std::span<const uint8_t> bytes(message_);
  const bool too_short = shorter.data_bytes < 8 ||
                         !decodes_(bytes.first(static_cast<std::size_t>(shorter.data_bytes)));
  return decodes_(bytes) && (too_short || longer.end - shorter.end < kHeaderBytes);
}

int64_t Repair::next_begin(int64_t from, int64_t to) const {
  std::array<uint8_t, kHeaderBytes> bytes{};
  if (to - from < kHeaderBytes || !reader_.read_at(from, bytes)) return to;
  const HeaderBytes header(bytes.data());
  const int64_t announced = from + kHeaderBytes + header.channel_bytes + header.data_bytes;
  if (announced == to || (announced < to && looks_like_sync(announced))) return announced;
  constexpr int64_t kBlock = 64 << 10;
  std::vector<uint8_t> block;
  for (int64_t start = from + 1; start + 4 <= to; start += kBlock - 3) {
    block.resize(static_cast<std::size_t>(std::min(kBlock, to - start)));
    if (!reader_.read_at(start, block)) return to;
    for (std::size_t i = 0; i + 4 <= block.size(); ++i) {
      const int same = (block[i] == 0xED ? 1 : 0) + (block[i + 1] == 0xA1 ? 1 : 0) +
                       (block[i + 2] == 0xDA ? 1 : 0) + (block[i + 3] == 0x01 ? 1 : 0);
      if (same >= 3) return start + static_cast<int64_t>(i);
    }
  }
  return to;
}

bool Repair::read_damaged(Event& event) {
  const int64_t body_bytes = event.end - event.offset - kHeaderBytes;
  constexpr int64_t kLargestBody = (256 << 20) + 63;
  if (body_bytes < 1 || body_bytes > kLargestBody) return false;
  std::array<uint8_t, kHeaderBytes + 63 + 8> bytes{};
  const auto wanted =
      static_cast<std::size_t>(std::min<int64_t>(bytes.size(), event.end - event.offset));
  if (!reader_.read_at(event.offset, std::span(bytes).first(wanted))) return false;
  const HeaderBytes header(bytes.data());
  const std::string_view following(reinterpret_cast<const char*>(bytes.data()) + kHeaderBytes,
                                   wanted - kHeaderBytes);
  const auto layout = lay_out(header, following, body_bytes, known_);
  if (!layout) return false;
  const int64_t announced = static_cast<int64_t>(header.channel_bytes) + header.data_bytes;
  event.number = header.number;
  event.event_time = header.event_time;
  event.channel = layout->channel;
  event.data_bytes = layout->data_bytes;
  event.fingerprint = read_fingerprint(following.substr(layout->channel_bytes));
  event.mended.push_back(layout->mended);
  const bool is_cut_off = announced > body_bytes && event.end == reader_.size_bytes();
  return announced == body_bytes || is_length_believable(event, is_cut_off);
}

// Whether a message may have the length that was worked out for it.
bool Repair::is_length_believable(const Event& event, bool is_cut_off) {
  if (const auto usual = known_.usual_data_bytes(event.channel)) return event.data_bytes == *usual;
  message_.resize(static_cast<std::size_t>(event.data_bytes));
  return !is_cut_off && reader_.read_at(event.end - event.data_bytes, message_) &&
         decodes_(message_);
}

void Repair::mend(Event& event, const Event* next) {
  if (known_.events(event.channel) <= 1) {
    if (const auto name = known_.nearest(event.channel, event.fingerprint)) {
      event.channel = *name;
      event.mended.push_back("channel");
    }
  }
  if (const auto usual = known_.mend_fingerprint(event.channel, event.fingerprint);
      usual && event.data_bytes >= 8) {
    event.fingerprint = *usual;
    event.mended.push_back("fingerprint");
  }
  EventPlace place;
  if (next != nullptr) place = {next->number, next->event_time};
  const EventPlace* behind = next != nullptr ? &place : nullptr;
  if (const auto time = sequence_.repaired_time(event.event_time, behind)) {
    event.event_time = *time;
    event.mended.push_back("time");
  }
  if (const auto number = sequence_.repaired_number(event.number, behind)) {
    event.number = *number;
    event.mended.push_back("number");
  }
}

void Repair::check_message(const Event& event) {
  message_.resize(static_cast<std::size_t>(event.data_bytes));
  if (!reader_.read_at(event.end - event.data_bytes, message_)) return;
  for (std::size_t i = 0; i < 8 && message_.size() >= 8; ++i) {
    message_[i] = static_cast<uint8_t>(event.fingerprint >> (56 - 8 * i));
  }
  if (!decodes_(message_)) ++report_.undecodable[event.channel];
}

void Repair::write(Event& event, const Event* next) {
  if (mending_ == Mending::headers) mend(event, next);
  check_message(event);
  if (event.mended.empty()) {
    copier_.add(event.offset, event.end);
    ++report_.untouched;
  } else {
    copier_.copy();
    out_.write(files::event_header(event.number, event.event_time, event.channel,
                                   static_cast<std::size_t>(event.data_bytes)));
    out_.write(event.channel);
    out_.write(message_);
    for (const char* what : event.mended) {
      ++report_.mended[what];
      if (report_.mended_events.size() < kListed) {
        report_.mended_events.push_back({event.number, event.offset, event.channel, what});
      }
    }
  }
  ++report_.events;
  sequence_.add({event.number, event.event_time});
}

}  // namespace

RepairReport repair_log(const std::filesystem::path& in,
                        OutputFile& out,
                        Mending mending,
                        const Decodes& decodes,
                        const OnProgress& on_progress) {
  return Repair(in, out, mending, decodes).run(on_progress);
}

}  // namespace marco::logs
