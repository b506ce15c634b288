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

PanTiltDriver::PanTiltDriver(const PanTiltOptions& options) : options_(options), head_(options_) {
  validate(options, "pantilt");
  require(options.pan.deg_per_unit != 0.0 && options.tilt.deg_per_unit != 0.0,
          "pantilt: deg_per_unit must not be 0");
}

std::string PanTiltDriver::state() const {
  static constexpr const char* kLinks[] = {
      "the pan-tilt does not answer", "the pan-tilt looks for its home", "the pan-tilt is ready"};
  return kLinks[static_cast<int>(link_)] + std::string(moving() ? ", moving" : "");
}

void PanTiltDriver::forget_move(Link link) {
  link_ = link;
  phase_ = Phase::idle;
  waits_ = false;
  next_command_.reset();
}

void PanTiltDriver::on_connection(bool connected, Utime now) {
  exchange_.on_connection(connected, now);
  forget_move(Link::down);
  head_.forget_stamps();
  next_status_ = {};
}

void PanTiltDriver::receive(std::span<const uint8_t> bytes, Utime now) {
  for (const std::string& line : exchange_.receive(bytes)) on_line(line, now);
}

// Such lines come only between a reset and the end of its homing.
void PanTiltDriver::on_message(const std::string& line, Utime now) {
  if (line.starts_with("Sistema")) ++resets_;
  exchange_.clear();
  forget_move(Link::homing);
  exchange_.ping_at(line == "Listo" ? now : now + Duration::from_seconds(3.0));
}

void PanTiltDriver::on_line(const std::string& line, Utime now) {
  if (is_message(line)) return on_message(line, now);
  const char letter = line.empty() ? '\0' : line.front();
  if (line == "w" && waits_) {
    waits_ = false;
    ask_status();
  } else if (letter == 'l' && exchange_.awaited() == 'l') {
    const auto status = parse_pantilt_status(line);
    if (!status) return exchange_.reject();
    exchange_.answered();
    on_status(*status, line_begun(line.size(), now), now);
  } else if (line.size() == 1 && letter == exchange_.awaited()) {
    exchange_.answered();
    if (phase_ != Phase::idle) head_.begin(letter, now);
  } else {
    return exchange_.reject();
  }
  exchange_.accept();
}

void PanTiltDriver::on_timeout(const LineExchange::Request& request, Utime now) {
  if (request.reply == 'p') {
    stop_answered_ = false;  // the listing's board: `p` is not dispatched
    exchange_.clear_queue();
    stop_at_next_unit();
    return;
  }
  if (!exchange_.is_silent_after_timeout()) {
    exchange_.ask_first(request);  // each of its commands may be sent twice
    return;
  }
  exchange_.clear();
  forget_move(Link::down);
  exchange_.ping_later(now);
}

void PanTiltDriver::command(const PanTiltCommand& command, Utime now) {
  if (link_ != Link::up) return;
  if (phase_ == Phase::idle) return begin(command, now);
  next_command_ = command;
  if (phase_ == Phase::moving) begin_stop();
}

void PanTiltDriver::begin(const PanTiltCommand& command, Utime now) {
  if (command.kind == PanTiltCommand::Kind::stop || !head_.plan(command)) return;
  phase_ = Phase::moving;
  exchange_.clear_queue();
  const std::vector<const HeadAxis*> axes = head_.moving_axes();
  for (const HeadAxis* axis : axes) {
    const Ramp& ramp = axis->ramp;
    exchange_.ask({encode_command(axis->ramp_letter, {ramp.start, ramp.top, ramp.step_ticks}),
                   axis->ramp_letter});
  }
  for (const HeadAxis* axis : axes) {
    exchange_.ask({encode_command(axis->go, {static_cast<uint32_t>(axis->to)}), axis->go});
  }
  next_status_ = now;
  if (head_.polled()) return;
  ask_wait(static_cast<uint32_t>(std::min<int64_t>(head_.longest_ticks() * 5 / 4 + 500, 65000)));
}

void PanTiltDriver::ask_wait(uint32_t ticks) {
  waits_ = true;
  exchange_.ask({encode_command('w', {ticks, 1, 1}), '\0'});  // the base wants four numbers
}

void PanTiltDriver::begin_stop() {
  phase_ = Phase::stopping;
  waits_ = false;
  exchange_.clear_queue();
  if (!stop_answered_) return stop_at_next_unit();
  exchange_.ask({encode_command('p'), 'p', 0.1});
  ask_status();
}

void PanTiltDriver::stop_at_next_unit() {
  for (const HeadAxis* axis : head_.shorten()) {
    exchange_.ask({encode_command(axis->go, {static_cast<uint32_t>(axis->to)}), axis->go});
  }
  ask_status();
}

void PanTiltDriver::on_status(const PanTiltStatus& status, Utime measured, Utime now) {
  link_ = Link::up;
  head_.on_status(status, measured);
  const bool still = !status.pan_on && !status.tilt_on;
  if (phase_ == Phase::stopping) {
    if (still) return come_to_rest(now);
    next_status_ = now + Duration::from_seconds(options_.poll_period_s);
  } else if (phase_ == Phase::moving && exchange_.quiet()) {
    if (still) return come_to_rest(now);
    if (!head_.polled()) ask_wait(500);
  }
}

void PanTiltDriver::come_to_rest(Utime now) {
  phase_ = Phase::idle;
  head_.come_to_rest();
  if (const auto next = std::exchange(next_command_, std::nullopt)) begin(*next, now);
}

void PanTiltDriver::schedule(Utime now) {
  if (link_ != Link::up) {
    if (exchange_.ping_due(now)) ask_status();
    return;
  }
  const bool ask = phase_ != Phase::moving || head_.polled() || !waits_;
  if (!ask || !exchange_.quiet() || now < next_status_) return;
  next_status_ = now + Duration::from_seconds(phase_ == Phase::idle ? options_.idle_period_s
                                                                    : options_.poll_period_s);
  ask_status();
}

void PanTiltDriver::advance(Utime now, std::vector<uint8_t>& out) {
  if (!exchange_.connected()) return;
  if (phase_ == Phase::moving) head_.follow_ramps(now);
  schedule(now);
  if (const auto late = exchange_.advance(now, out)) on_timeout(*late, now);
}

void PanTiltDriver::shut_down(std::vector<uint8_t>& out) const {
  std::string words = "\np\n";
  if (phase_ != Phase::idle) {  // one of the two is understood
    for (const HeadAxis* axis : head_.moving_axes()) {
      const auto unit = static_cast<uint32_t>(std::max(0.0, std::round(axis->place.units)));
      words += encode_command(axis->go, {unit});
    }
  }
  out.insert(out.end(), words.begin(), words.end());
}

}  // namespace marco::drivers::hcs12
