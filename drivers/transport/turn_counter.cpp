#include "drivers/transport/turn_counter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers {
namespace {

// How much sooner or later than usual a scan may follow the one before [turns]. One that comes
// sooner had waited somewhere.
constexpr double kInTime = 0.2;
constexpr double kLate = 0.5;
constexpr double kSilenceS = 1.0;
constexpr std::size_t kSteps = 8;

}  // namespace

void TurnCounter::reset() { *this = TurnCounter(turn_s_); }

double TurnCounter::update(Utime end, Gap gap) {
  turns_ += turns_ < 0 ? 1 : turns_since((end - last_).seconds() / turn_s_, gap);
  last_ = end;
  return static_cast<double>(turns_) * turn_s_;
}

// After a pause of the host one scan comes late and those behind it all at once. After missed turns
// one scan comes late and the next at its usual time.
int64_t TurnCounter::turns_since(double elapsed, Gap gap) {
  const auto rounded = static_cast<int64_t>(std::llround(elapsed));
  const double silence = kSilenceS / turn_s_ + 2.0 * static_cast<double>(usual_);
  if (gap == Gap::any || usual_ == 0 || elapsed > silence) {
    behind_ = 0.0;
    if (gap == Gap::none && elapsed <= silence) learn(rounded);
    // Zero turns: the scan before came late and was taken for a later one.
    return std::max<int64_t>(0, rounded);
  }
  const double over = elapsed - static_cast<double>(usual_);
  if (behind_ > 0.0 && over < -kInTime) {
    behind_ += over;
    if (behind_ < 0.5) behind_ = 0.0;
    return usual_;
  }
  const int64_t missed = std::llround(std::exchange(behind_, 0.0));
  if (over > kLate) {
    behind_ = over;
    const int64_t turns = usual_ + missed;
    if (missed > 0) learn(rounded);  // twice in a row is no accident
    return turns;
  }
  learn(rounded);
  return std::max<int64_t>(1, rounded) + missed;
}

void TurnCounter::learn(int64_t turns) {
  steps_.push_back(std::max<int64_t>(1, turns));
  if (steps_.size() > kSteps) steps_.pop_front();
  const auto times = [this](int64_t step) {
    return std::count(steps_.begin(), steps_.end(), step);
  };
  usual_ = *std::max_element(steps_.begin(), steps_.end(), [&](int64_t a, int64_t b) {
    return std::pair(times(a), a) < std::pair(times(b), b);
  });
}

}  // namespace marco::drivers
