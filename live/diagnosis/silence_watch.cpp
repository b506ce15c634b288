#include "live/diagnosis/silence_watch.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "lcm_tools/process/lcm_bus.hpp"

namespace marco::diagnosis {
namespace {

constexpr double kListenS = 1.5;    // a survey: long enough for channels at 1 Hz
constexpr double kAheadS = 2.0;     // a survey is done when it is wanted
constexpr double kNextLookS = 2.0;  // between two surveys
constexpr double kStaleS = 10.0;    // an older survey is worthless
constexpr double kAtLeastS = 5.0;   // between two notes
constexpr double kFirstRepeatS = 60.0, kLastRepeatS = 3600.0;
constexpr std::size_t kSituations = 20;

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

SilenceWatch::SilenceWatch(process::LcmBus& bus, Options options)
    : options_(std::move(options)), judge_(options_.expectations, options_.drops) {
  try {
    url_ = parse_udp_url(process::effective_lcm_url(options_.url));
  } catch (const std::invalid_argument&) {
    survey_.emplace();
  }
  bus.set_tap([this](const process::RawMessage& raw) { judge_.heard(raw); });
}

SilenceWatch::~SilenceWatch() {
  stop_ = true;
  if (looking_.valid()) looking_.wait();
}

std::optional<Note> SilenceWatch::step() {
  const double now_s = steady_s();
  judge_.advance(now_s);
  if (url_) look(now_s);
  lacks_ = judge_.lacks();
  if (!lacks_.empty()) return tell(now_s);
  if (told_.empty()) return std::nullopt;
  told_.clear();
  return Note{false, "heard now: " + judge_.what_comes()};
}

// Surveys the bus while something is missed, or soon will be.
void SilenceWatch::look(double now_s) {
  if (looking_.valid()) {
    if (looking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    survey_ = looking_.get();
    surveyed_s_ = now_s;
  }
  if (survey_ && now_s - surveyed_s_ > kStaleS) survey_.reset();
  if (survey_ && now_s - surveyed_s_ < kNextLookS) return;
  if (judge_.lacks(kAheadS).empty()) return;
  looking_ = std::async(std::launch::async, [url = *url_, program = options_.program, this] {
    return survey_bus(url, program, kListenS, stop_);
  });
}

std::optional<Note> SilenceWatch::tell(double now_s) {
  if (!survey_ || (!told_.empty() && now_s - told_s_ < kAtLeastS)) return std::nullopt;
  const std::string now = situation(lacks_, *survey_);
  const bool known = told_.contains(now) || told_.size() >= kSituations;
  if (known && now_s < tell_again_s_) return std::nullopt;
  const double repeat_s =
      known ? std::clamp(2.0 * (tell_again_s_ - told_s_), kFirstRepeatS, kLastRepeatS)
            : kFirstRepeatS;
  told_.insert(now);
  told_s_ = now_s;
  tell_again_s_ = now_s + repeat_s;
  return Note{true, silence_text(lacks_, *survey_)};
}

std::optional<Note> SilenceWatch::last_word() {
  lacks_ = judge_.lacks(SilenceJudge::kEndedS);
  if (lacks_.empty() || !told_.empty()) return std::nullopt;
  if (looking_.valid()) survey_ = looking_.get();
  if (!survey_) survey_ = survey_bus(*url_, options_.program, kListenS, stop_);
  return Note{true, silence_text(lacks_, *survey_)};
}

std::string SilenceWatch::state(const std::string& otherwise) const {
  return lacks_.empty() ? otherwise : short_state(lacks_.front()) + "; " + otherwise;
}

std::vector<Finding> SilenceWatch::network() const {
  return survey_ && !lacks_.empty() ? survey_->network : std::vector<Finding>();
}

void log_note(const std::optional<Note>& note) {
  if (note)
    spdlog::log(note->trouble ? spdlog::level::warn : spdlog::level::info, "{}", note->text);
}

}  // namespace marco::diagnosis
