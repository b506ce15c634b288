#include "drivers/devices/probe.hpp"

#include <algorithm>
#include <vector>

#include "drivers/devices/listening.hpp"
#include "drivers/devices/questions.hpp"

namespace marco::drivers::devices {
namespace {

using Bytes = std::vector<uint8_t>;
using std::chrono::microseconds;

// Boards that start when the port opens, lasers on power: they speak within this.
constexpr double kFirstListenS = 2.5;
// The rarest stream of Marco's devices is an IMU's, ten times a second.
constexpr double kQuietS = 0.25;
// Of the largest telegram, a SICK's of 733 bytes, two after a part: bits.
constexpr double kTwoTelegrams = 22'000.0;
constexpr double kMostListenS = 2.6;
constexpr double kAnswerS = 0.15, kLongestAnswerS = 0.6;
constexpr Duration kJudgePeriod = Duration::from_us(100'000);  // it costs some milliseconds
constexpr std::size_t kMostBytes = 16'384;

/// Lines come back from many devices, from a SCIP laser for one.
bool is_binary(const Bytes& question) {
  return std::any_of(question.begin(), question.end(), [](uint8_t byte) { return byte > 0x7F; });
}

bool holds(const Bytes& answer, const Bytes& sent) {
  return std::search(answer.begin(), answer.end(), sent.begin(), sent.end()) != answer.end();
}

class Prober {
 public:
  Prober(ByteStream& stream, const Clock& clock, Reach reach)
      : stream_(stream), clock_(clock), reach_(reach) {}

  Finding run(Manner manner) {
    listen_at_all_rates();
    if (manner != Manner::listen && best_.claim.kind <= Kind::bytes) ask_all(manner);
    return best_;
  }

 private:
  void listen_at_all_rates() {
    if (reach_ == Reach::network) return listen(0, kFirstListenS);
    for (const int baud : rates()) {
      const double whole_s = std::min(kMostListenS, kQuietS + kTwoTelegrams / baud);
      const bool first = baud == rates().front();
      listen(baud, first ? kFirstListenS : heard_any_ ? whole_s : kQuietS);
      if (best_.claim.kind >= Kind::text) return;
    }
  }

  bool set_line(int baud) {
    try {
      if (baud > 0) stream_.set_line({baud, Parity::none});
    } catch (const std::invalid_argument&) {
      return false;  // a rate that this port cannot do
    }
    stream_.discard_input();
    return true;
  }

  void listen(int baud, double time_s) {
    if (!set_line(baud)) return;
    Bytes heard;
    int64_t count = 0;
    const Utime begin = clock_();
    Claim claim;
    while ((clock_() - begin).seconds() < time_s && claim.kind <= Kind::text) {
      const Utime judge_at = clock_() + kJudgePeriod;
      std::size_t more = 0;
      while (clock_() < judge_at) more += read(heard);
      count += static_cast<int64_t>(more);
      if (more > 0) claim = judge(heard, Kind::silence);
    }
    heard_any_ = heard_any_ || count > 0;
    const double took_s = std::max(1e-3, (clock_() - begin).seconds());
    if (claim.kind > best_.claim.kind) {
      best_ = {claim, baud, static_cast<double>(count) / took_s, false};
    }
  }

  std::size_t read(Bytes& heard) {
    uint8_t buffer[4096];
    const std::size_t count = stream_.read(buffer, microseconds(20'000));
    heard.insert(heard.end(), buffer, buffer + count);
    if (heard.size() > kMostBytes) {
      heard.erase(heard.begin(), heard.end() - static_cast<std::ptrdiff_t>(kMostBytes));
    }
    return count;
  }

  void ask_all(Manner manner) {
    for (const Question& question : reach_ == Reach::network ? network_questions() : questions()) {
      if (question.on_request && manner != Manner::ask_all) continue;
      if (!set_line(question.baud)) continue;
      stream_.write(question.bytes);
      const Bytes answer = listen_to_answer();
      const Claim claim = judge(answer, question.whom);
      if (is_device(claim.kind)) {
        best_.claim = claim;
        best_.baud = question.baud;
        if (claim.kind == question.whom) stream_.write(question.afterwards);
        return;
      }
      best_.echoes = is_binary(question.bytes) && holds(answer, question.bytes);
      if (claim.kind == Kind::login) best_.claim = claim;
      if (best_.echoes || claim.kind == Kind::login) {
        best_.baud = question.baud;
        return;
      }
    }
  }

  Bytes listen_to_answer() {
    Bytes answer;
    const Utime begin = clock_();
    Utime last = begin;
    while ((clock_() - last).seconds() < kAnswerS &&
           (clock_() - begin).seconds() < kLongestAnswerS) {
      if (read(answer) > 0) last = clock_();
    }
    return answer;
  }

  ByteStream& stream_;
  const Clock& clock_;
  Reach reach_;
  Finding best_;
  bool heard_any_ = false;
};

}  // namespace

Finding probe(ByteStream& stream, const Clock& clock, Manner manner, Reach reach) {
  return Prober(stream, clock, reach).run(manner);
}

}  // namespace marco::drivers::devices
