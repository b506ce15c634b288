#include "simulator/devices/transport/simulated_line.hpp"

#include <algorithm>

namespace marco::drivers {

class SimulatedStream final : public ByteStream {
 public:
  SimulatedStream(SimulatedLine& line, int baud)
      : line_(line), session_(line.session_), baud_(baud) {}
  ~SimulatedStream() override {
    if (session_ == line_.session_) line_.disconnect();
  }

  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override {
    const Utime limit = line_.now_ + Duration::from_us(timeout.count());
    check();
    line_.step_towards(line_.now_);
    while (line_.to_client_.empty() && line_.now_ < limit) {
      line_.step_towards(limit);
      check();
    }
    std::vector<uint8_t>& waiting = line_.to_client_;
    const std::size_t count = std::min(into.size(), waiting.size());
    std::copy_n(waiting.begin(), count, into.begin());
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

  void write(std::span<const uint8_t> bytes) override {
    check();
    std::vector<uint8_t> sent(bytes.begin(), bytes.end());
    if (line_.tamper_to_device_) line_.tamper_to_device_(sent);
    line_.emulator_.receive(sent, baud_, line_.now_);
  }

  void set_line(const LineSettings& line) override {
    check();
    if (line_.has_baud_) baud_ = line.baud;
    line_.emulator_.receive({}, baud_, line_.now_);
  }

  void discard_input() override { line_.to_client_.clear(); }

 private:
  void check() const {
    if (session_ != line_.session_) throw StreamLost("the simulated plug was pulled");
  }

  SimulatedLine& line_;
  int session_;
  int baud_;
};

SimulatedLine::SimulatedLine(Emulator& emulator, bool has_baud, Utime start)
    : emulator_(emulator), has_baud_(has_baud), now_(start) {}

std::unique_ptr<ByteStream> SimulatedLine::open(const LineSettings& line) {
  if (!plugged_) throw StreamLost("nothing is plugged in");
  if (connected_) throw std::invalid_argument("another driver holds this port");
  connected_ = true;
  to_client_.clear();
  emulator_.on_connection(true, now_);
  auto stream = std::make_unique<SimulatedStream>(*this, has_baud_ ? line.baud : 0);
  stream->set_line(line);
  return stream;
}

void SimulatedLine::disconnect() {
  connected_ = false;
  ++session_;
  emulator_.on_connection(false, now_);
}

void SimulatedLine::unplug() {
  plugged_ = false;
  if (connected_) disconnect();
}

void SimulatedLine::wait(Duration duration) {
  const Utime limit = now_ + duration;
  do {
    step_towards(limit);
  } while (now_ < limit);
}

void SimulatedLine::at(Utime when, std::function<void()> action) {
  actions_.emplace_back(when, std::move(action));
  std::stable_sort(actions_.begin(), actions_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
}

void SimulatedLine::step_towards(Utime limit) {
  Utime next = std::min(limit, std::max(emulator_.next_event(), held_until_));
  if (!actions_.empty()) next = std::min(next, actions_.front().first);
  now_ = std::max(now_, next);
  std::vector<uint8_t> left;
  if (now_ >= held_until_) emulator_.advance(now_, left);
  if (connected_) {
    if (tamper_to_client_ && !left.empty()) tamper_to_client_(left);
    to_client_.insert(to_client_.end(), left.begin(), left.end());
  }
  while (!actions_.empty() && actions_.front().first <= now_) {
    const auto action = std::move(actions_.front().second);
    actions_.erase(actions_.begin());
    action();
  }
}

}  // namespace marco::drivers
