#include "drivers/hcs12/pantilt_driver.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

// What the board says while it boots and looks for its home; noise makes lines, too.
bool is_message(const std::string& line) {
  static constexpr std::string_view kBeginnings[] = {"Sistema ROCA", "Girando a", "Se alcanz",
                                                     "Se liber",     "Giro de",   "Motor de",
                                                     "Hacia ",       "Listo"};
  return std::any_of(std::begin(kBeginnings), std::end(kBeginnings),
                     [&line](std::string_view words) { return line.starts_with(words); });
}

}  // namespace

PanTiltDriver::PanTiltDriver(const PanTiltOptions& options) : options_(options) {
  validate(options, "pantilt");
  require(options.pan.deg_per_unit != 0.0 && options.tilt.deg_per_unit != 0.0,
          "pantilt: deg_per_unit must not be 0");
  pan_.options = options.pan;
  tilt_.options = options.tilt;
  tilt_.go = 'e';
  tilt_.ramp_letter = 'K';
}

std::vector<PanTiltState> PanTiltDriver::take_states() { return std::exchange(states_, {}); }

std::string PanTiltDriver::state() const {
  static const char* const kLinks[] = {"the pan-tilt does not answer",
                                       "the pan-tilt looks for its home", "the pan-tilt is ready"};
  return kLinks[static_cast<int>(link_)] + std::string(moving() ? ", moving" : "");
}

void PanTiltDriver::on_connection(bool connected, Utime now) {
  connected_ = connected;
  exchange_.clear();
  phase_ = Phase::idle;
  link_ = Link::down;
  wait_armed_ = false;
  wanted_.reset();
  last_stamp_ = next_status_ = next_prediction_ = {};  // the host's clock may have been set back
  silent_ = 0;
  next_ping_ = now;
}

void PanTiltDriver::receive(std::span<const uint8_t> bytes, Utime now) {
  for (const std::string& line : exchange_.receive(bytes)) on_line(line, now);
}

void PanTiltDriver::on_line(const std::string& line, Utime now) {
  if (is_message(line)) {
    // The board speaks such lines only between a reset and the end of its homing.
    if (line.rfind("Sistema", 0) == 0) ++resets_;
    exchange_.clear();
    phase_ = Phase::idle;
    wait_armed_ = false;
    wanted_.reset();
    link_ = Link::homing;
    next_ping_ = line == "Listo" ? now : now + Duration::from_seconds(3.0);
    return;
  }
  const char letter = line.empty() ? '\0' : line.front();
  if (line == "w" && wait_armed_) {
    wait_armed_ = false;
    ask_status();
  } else if (letter == 'l' && exchange_.awaited() == 'l') {
    const auto status = parse_pantilt_status(line);
    if (!status) {
      ++bad_lines_;
      return;
    }
    exchange_.answered();
    on_status(*status, line_begun(line.size(), now), now);
  } else if (line.size() == 1 && letter == exchange_.awaited()) {
    exchange_.answered();
    for (Axis* axis : {&pan_, &tilt_}) {
      if (letter != axis->go || phase_ == Phase::idle) continue;
      axis->started = true;
      axis->started_at = now;
    }
  } else {
    ++bad_lines_;
    return;
  }
  silent_ = 0;
}

void PanTiltDriver::on_timeout(const LineExchange::Request& request, Utime now) {
  if (request.reply == 'p') {
    stop_answered_ = false;  // the listing's board: `p` is not dispatched
    exchange_.clear_queue();
    stop_by_going_on();
    return;
  }
  if (++silent_ < 3) {
    exchange_.ask_first(request);  // each of its commands may be said twice
    return;
  }
  exchange_.clear();
  phase_ = Phase::idle;
  wait_armed_ = false;
  wanted_.reset();
  link_ = Link::down;
  next_ping_ = now + Duration::from_seconds(kPingS);
}

void PanTiltDriver::schedule(Utime now) {
  if (!exchange_.quiet()) return;
  if (link_ != Link::up) {
    if (now < next_ping_) return;
    next_ping_ = now + Duration::from_seconds(kPingS);
    ask_status();
    return;
  }
  const bool ask = phase_ != Phase::moving || polled() || !wait_armed_;
  if (!ask || now < next_status_) return;
  next_status_ = now + Duration::from_seconds(phase_ == Phase::idle ? options_.idle_period_s
                                                                    : options_.poll_period_s);
  ask_status();
}

void PanTiltDriver::advance(Utime now, std::vector<uint8_t>& out) {
  if (!connected_) return;
  if (phase_ == Phase::moving) follow_ramps(now);
  schedule(now);
  if (const auto late = exchange_.advance(now, out)) on_timeout(*late, now);
}

void PanTiltDriver::shut_down(std::vector<uint8_t>& out) const {
  std::string words = "\np\n";
  if (!stop_answered_ && phase_ != Phase::idle) {
    words = "\n";
    for (const Axis* axis : {&pan_, &tilt_}) {
      const auto unit = static_cast<uint32_t>(std::max(0.0, std::round(axis->units)));
      if (axis->moves()) words += encode_command(axis->go, {unit});
    }
  }
  out.insert(out.end(), words.begin(), words.end());
}

}  // namespace marco::drivers::hcs12
