#include "lcm_tools/log/player.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::logs {

ChannelRenames::ChannelRenames(const std::vector<std::string>& rules) {
  for (const std::string& rule : rules) {
    const std::size_t equals = rule.find('=');
    require(equals != std::string::npos && equals > 0 && equals + 1 < rule.size(),
            "'" + rule + "': a rename is OLD=NEW");
    try {
      rules_.emplace_back(std::regex(rule.substr(0, equals), std::regex::extended),
                          rule.substr(equals + 1));
    } catch (const std::regex_error&) {
      throw std::invalid_argument("'" + rule + "': OLD is neither a name nor a regular expression");
    }
  }
}

std::string ChannelRenames::operator()(const std::string& channel) const {
  std::smatch match;
  for (const auto& [pattern, replacement] : rules_) {
    if (std::regex_match(channel, match, pattern)) return match.format(replacement);
  }
  return channel;
}

Player::Player(const std::string& path,
               ChannelChoice channels,
               const PlayerOptions& options,
               Publish publish)
    : reader_(path),
      channels_(std::move(channels)),
      options_(options),
      publish_(std::move(publish)),
      span_(find_span(reader_)) {
  require(options.speed >= 0.0 && std::isfinite(options.speed), "a speed is 0 or above");
  rewind(0);
}

// The next event that is to be played.
bool Player::load_next() {
  while ((next_ = reader_.next_head())) {
    if (options_.range.contains(bounded(next_->event_time)) && channels_.keeps(next_->channel)) {
      return true;
    }
    // Logs are nearly in order: what lies a minute behind the range ends the search.
    constexpr Duration kDisorder = Duration::from_us(60000000);
    const Utime to = bounded(options_.range.to);
    if (bounded(next_->event_time) > to + kDisorder) break;
  }
  next_.reset();
  return false;
}

void Player::start_count_at(Utime event_time, int64_t now_us) {
  count_event_ = event_time;
  count_now_us_ = now_us;
  count_started_ = true;
}

int64_t Player::due_us(Utime event_time) const {
  if (options_.speed <= 0.0) return count_now_us_;
  constexpr double kFarUs = 1e15;  // 30 years
  const double wait_us = static_cast<double>((event_time - count_event_).us) / options_.speed;
  return count_now_us_ + static_cast<int64_t>(std::clamp(wait_us, -kFarUs, kFarUs));
}

void Player::publish_next() {
  const std::string channel(next_->channel);
  position_ = bounded(next_->event_time);
  if (publish_(channel, reader_.data(), next_->event_time)) ++published_;
  load_next();
}

std::optional<int64_t> Player::advance(int64_t now_us) {
  constexpr int kEventsACall = 256;
  constexpr int64_t kLateUs = 500000;
  constexpr int64_t kBackUs = 1000000;
  if (options_.paused || finished_) return std::nullopt;
  for (int count = 0; count < kEventsACall; ++count) {
    if (!next_) {
      if (!options_.loop) {
        finished_ = true;
        return std::nullopt;
      }
      rewind(now_us);
      if (!next_) finished_ = true;
      return finished_ ? std::nullopt : std::optional(now_us);
    }
    const Utime time = bounded(next_->event_time);
    if (!count_started_ || (time - position_).us < -kBackUs) start_count_at(time, now_us);
    int64_t due = due_us(time);
    if (now_us - due > kLateUs) start_count_at(time, due = now_us);
    if (due > now_us && due - now_us > options_.longest_wait.us) {
      due = now_us + options_.longest_wait.us;
      start_count_at(time, due);
    }
    if (options_.speed > 0.0 && due > now_us) return due;
    publish_next();
  }
  return now_us;
}

void Player::set_paused(bool paused, int64_t now_us) {
  options_.paused = paused;
  start_count_at(position_, now_us);
}

void Player::set_speed(double speed, int64_t now_us) {
  require(speed >= 0.0 && std::isfinite(speed), "a speed is 0 or above");
  // What has passed since the count began passed at the old speed.
  if (count_started_ && !options_.paused) {
    const double passed_us = static_cast<double>(now_us - count_now_us_) * options_.speed;
    start_count_at(count_event_ + Duration::from_us(static_cast<int64_t>(passed_us)), now_us);
  }
  options_.speed = speed;
}

void Player::step(int64_t now_us) {
  if (!next_ && options_.loop) rewind(now_us);
  options_.paused = true;
  if (next_) publish_next();
}

void Player::seek(Utime time, int64_t now_us) {
  // Between `low` (before the moment) and `high` (not before it) lies where it begins.
  int64_t low = 0, high = reader_.size_bytes();
  constexpr int64_t kNear = 64 << 10;
  while (high - low > kNear) {
    const int64_t middle = low + (high - low) / 2;
    reader_.seek(middle);
    const auto head = reader_.next_head();
    if (!head || head->offset >= high || bounded(head->event_time) >= time) {
      high = middle;
    } else {
      low = head->offset;
    }
  }
  reader_.seek(low);
  while (load_next() && bounded(next_->event_time) < time) {
  }
  stand_at(time, now_us);
}

void Player::rewind(int64_t now_us) {
  if (options_.range.from > span_.first) return seek(options_.range.from, now_us);
  reader_.seek(0);
  load_next();
  stand_at(span_.first, now_us);
}

void Player::stand_at(Utime time, int64_t now_us) {
  finished_ = false;
  position_ = time;
  start_count_at(time, now_us);
  count_started_ = false;
}

std::optional<Utime> Player::next_time() const {
  if (!next_) return std::nullopt;
  return bounded(next_->event_time);
}

}  // namespace marco::logs
