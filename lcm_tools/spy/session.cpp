#include "lcm_tools/spy/session.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"
#include "lcm_tools/spy/page_text.hpp"
#include "lcm_tools/spy/painter.hpp"
#include "lcm_tools/spy/receiver.hpp"
#include "lcm_tools/spy/report.hpp"
#include "lcm_tools/spy/watcher.hpp"

namespace marco::spy {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int64_t kLongestGapUs = 60'000'000;

/// Plays a log into a model at its own pace, in a thread; gaps of more than a minute are jumped.
class LogPlayer {
 public:
  struct Options {
    std::string path;
    double speed = 1;       ///< 0 = as fast as it can be read
    double duration_s = 0;  ///< from the first event; 0 = all
  };
  /// @throws std::invalid_argument naming the path when it cannot be read.
  LogPlayer(const Options& options, SharedModel& shared);
  ~LogPlayer();
  LogPlayer(const LogPlayer&) = delete;
  LogPlayer& operator=(const LogPlayer&) = delete;

  /// Stops or starts the log's clock.
  void pause(bool on) { paused_ = on; }
  bool ended() const { return ended_; }
  /// The log's clock.
  int64_t now_us() const { return now_us_; }
  /// What was damaged. Call after ended().
  const files::LogDamage& damage() const { return reader_.damage(); }

 private:
  void run();
  void wait_for(int64_t time_us);

  Options options_;
  SharedModel& shared_;
  files::EventLogReader reader_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> paused_ = false;
  std::atomic<bool> ended_ = false;
  std::atomic<int64_t> now_us_ = 0;
  std::thread thread_;
};

/// A log's event time [us], kept where differences do not overflow.
int64_t bounded_time_us(const files::LogEvent& event) {
  return std::clamp<int64_t>(event.event_time.us, 0, int64_t{1} << 60U);
}

std::string damage_text(const files::LogDamage& damage) {
  return "the log is damaged: " + std::to_string(damage.places) + " places, " +
         std::to_string(damage.bytes_skipped) + " bytes skipped";
}

LogPlayer::LogPlayer(const Options& options, SharedModel& shared)
    : options_(options), shared_(shared), reader_(options.path), thread_([this] { run(); }) {}

LogPlayer::~LogPlayer() {
  stop_ = true;
  thread_.join();
}

void LogPlayer::run() {
  std::optional<int64_t> first_us;
  while (const auto event = reader_.next()) {
    const int64_t time_us = bounded_time_us(*event);
    if (!first_us) {
      first_us = time_us;
      now_us_ = time_us;
    }
    const double into_log_s = static_cast<double>(time_us - *first_us) * 1e-6;
    if (options_.duration_s > 0 && into_log_s > options_.duration_s) break;
    if (options_.speed > 0) wait_for(time_us);
    if (stop_) return;
    now_us_ = std::max(now_us_.load(), time_us);
    const SharedModel::Look look(shared_);
    shared_.model.add_message(time_us, event->channel, event->bytes);
  }
  ended_ = true;
}

void LogPlayer::wait_for(int64_t time_us) {
  if (time_us - now_us_ > kLongestGapUs) now_us_ = time_us;
  auto last = Clock::now();
  while (!stop_ && now_us_ < time_us) {
    const double left_us = static_cast<double>(time_us - now_us_) / options_.speed;
    std::this_thread::sleep_for(
        std::chrono::duration<double, std::micro>(std::clamp(left_us, 1.0, 20000.0)));
    const auto now = Clock::now();
    if (!paused_) {
      const double passed_us = std::chrono::duration<double, std::micro>(now - last).count();
      now_us_ += static_cast<int64_t>(passed_us * options_.speed);
    }
    last = now;
  }
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class Session {
 public:
  explicit Session(const SessionOptions& options)
      : options_(options),
        schema_(lcm_schema::load_schema(built_in_sources(), options.types, around_.problems)),
        decoder_(schema_),
        shared_(decoder_) {
    require(options.duration_s >= 0 && options.duration_s < 1e8,
            "--duration must be 0 to 1e8 seconds");
    require(options.speed >= 0 && options.speed <= 1e6, "--speed must be 0 to 1e6");
    if (!options.extensions.hints.empty()) around_.hints = options.extensions.hints;
    around_.is_log = !options.log.empty();
    around_.speed = options.speed;
    view_.selected = options.channel;
    if (!options.channel.empty()) view_.page = Page::channel;
    if (options.page == "who") view_.page = Page::who;
    if (options.page == "picture") view_.page = Page::picture;
    if (options.page.starts_with("plot:")) {
      view_.page = Page::plot;
      view_.plotted.push_back(options.page.substr(5));
    }
  }

  int run() {
    if (around_.is_log && options_.once) return read_log();
    if (around_.is_log) {
      around_.source = options_.log;
      player_ = std::make_unique<LogPlayer>(
          LogPlayer::Options{options_.log, options_.speed, options_.duration_s}, shared_);
      around_.overall_rates = options_.speed == 0;
    } else {
      const diagnosis::UdpUrl url =
          diagnosis::parse_udp_url(process::effective_lcm_url(options_.lcm_url));
      around_.source = url.text();
      receiver_ = std::make_unique<Receiver>(url, shared_);
      watcher_ = std::make_unique<Watcher>(url, shared_, *receiver_);
    }
    if (options_.once) return listen_once();
    return options_.json ? stream_json() : show();
  }

 private:
  std::string why_no_log() const {
    return options_.extensions.explain_no_log ? options_.extensions.explain_no_log(options_.log)
                                              : options_.log + ": has no complete LCM event";
  }

  int read_log() {
    files::EventLogReader reader(options_.log);
    around_.source = options_.log;
    around_.overall_rates = true;
    process::Progress progress("reading " + options_.log);
    std::optional<int64_t> first_us;
    int64_t events = 0;
    while (const auto event = reader.next()) {
      const int64_t time_us = bounded_time_us(*event);
      if (!first_us) first_us = time_us;
      const double into_log_s = static_cast<double>(time_us - *first_us) * 1e-6;
      if (options_.duration_s > 0 && into_log_s > options_.duration_s) break;
      shared_.model.add_message(time_us, event->channel, event->bytes);
      if (++events % 4096 == 0)
        progress.update(static_cast<double>(reader.position_bytes()) /
                        static_cast<double>(reader.size_bytes()));
    }
    if (reader.damage().places > 0) around_.problems.push_back(damage_text(reader.damage()));
    if (events == 0) around_.problems.push_back(why_no_log());
    around_.log_ended = true;
    around_.now_us = shared_.model.last_us();
    print_report();
    return shared_.model.messages() > 0 ? 0 : 1;
  }

  int listen_once() {
    const auto start = Clock::now();
    const double duration_s = options_.duration_s > 0 ? options_.duration_s : 2;
    while (seconds_since(start) < duration_s && !process::stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    watcher_->look(Watcher::Depth::silence_too);
    watcher_->copy_to(around_);
    around_.overall_rates = true;
    around_.now_us = process::wall_clock_us();
    const SharedModel::Look look(shared_);
    shared_.model.settle(around_.now_us);
    print_report();
    return shared_.model.messages() > 0 ? 0 : 1;
  }

  void print_report() {
    if (options_.json) {
      std::puts(json_report(shared_.model, around_).c_str());
      return;
    }
    const int width = options_.width > 0 ? options_.width : 120;
    const int channels = static_cast<int>(shared_.model.channels().size());
    const int rows = (channels == 0 ? 12 : channels + 8) +
                     rows_of_findings(around_, width, Problems::first_three);
    const int height = options_.height > 0         ? options_.height
                       : view_.page == Page::table ? rows
                                                   : 30;
    const Canvas canvas = draw(shared_.model, view_, around_, width, height);
    // The last row is the keys'; empty rows above it say nothing.
    std::string text = canvas.to_text();
    text.resize(text.rfind('\n', text.size() - 2) + 1);
    while (text.ends_with("\n\n")) text.pop_back();
    std::fputs(text.c_str(), stdout);
  }

  bool time_is_over(Clock::time_point start) const {
    return process::stop_requested() || (options_.duration_s > 0 && !around_.is_log &&
                                         seconds_since(start) >= options_.duration_s);
  }

  void refresh() {
    if (watcher_) watcher_->copy_to(around_);
    {
      const SharedModel::Look look(shared_);
      if (auto heard = emergency_stop(shared_.model)) around_.emergency = std::move(heard);
    }
    around_.now_us = player_ ? player_->now_us() : process::wall_clock_us();
    if (player_ && player_->ended() && !around_.log_ended) {
      around_.log_ended = true;
      if (player_->damage().places > 0) around_.problems.push_back(damage_text(player_->damage()));
      const SharedModel::Look look(shared_);
      if (shared_.model.messages() == 0) around_.problems.push_back(why_no_log());
    }
  }

  int stream_json() {
    const auto start = Clock::now();
    for (auto next = start + std::chrono::seconds(1); !around_.log_ended;
         next += std::chrono::seconds(1)) {
      while (Clock::now() < next && !time_is_over(start) && !(player_ && player_->ended())) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
      refresh();
      std::string line;
      {
        const SharedModel::Look look(shared_);
        shared_.model.settle(around_.now_us);
        line = json_report(shared_.model, around_);
      }
      std::puts(line.c_str());
      if (std::fflush(stdout) != 0 || time_is_over(start)) break;
    }
    return 0;
  }

  int show() {
    const auto start = Clock::now();
    int64_t frames = 0;
    {
      Painter painter;
      auto next_frame = start;
      while (!time_is_over(start)) {
        refresh();
        painter.paint(frame(painter.width(), painter.height()));
        ++frames;
        next_frame = std::max(next_frame + std::chrono::milliseconds(100), Clock::now());
        // A key is answered at once, with a frame of its own.
        const auto wait =
            std::chrono::duration_cast<std::chrono::milliseconds>(next_frame - Clock::now());
        const auto press = painter.key(static_cast<int>(std::max<int64_t>(0, wait.count())));
        if (press && !act(*press)) break;
        // A terminal that is gone answers at once for ever.
        if (!press) std::this_thread::sleep_until(next_frame);
      }
    }
    const SharedModel::Look look(shared_);
    std::printf("%lld messages received, %lld lost, %lld frames in %.1f s\n",
                static_cast<long long>(shared_.model.messages()),
                static_cast<long long>(shared_.model.lost()), static_cast<long long>(frames),
                seconds_since(start));
    return 0;
  }

  Canvas frame(int width, int height) {
    if (frozen_) {
      Surroundings then = around_;
      then.now_us = frozen_at_us_;
      return draw(*frozen_, view_, then, width, height);
    }
    const SharedModel::Look look(shared_);
    if (watcher_) shared_.model.settle(around_.now_us);
    return draw(shared_.model, view_, around_, width, height);
  }

  // A recording's robots are beyond orders.
  void order(process::EmergencyStop what) {
    if (around_.is_log) return;
    if (!bus_) bus_ = std::make_unique<process::LcmBus>(options_.lcm_url);
    process::send_emergency_stop(
        *bus_, what, "marco-spy",
        what == process::EmergencyStop::engage ? "stop key" : "release key");
  }

  // @returns false to quit.
  bool act(KeyPress press) {
    const SharedModel::Look look(shared_);
    Model& model = shared_.model;
    switch (handle_key(view_, press, frozen_ ? *frozen_ : model, around_)) {
      case Action::none:
        break;
      case Action::quit:
        return false;
      case Action::clear:
        model.clear();
        break;
      case Action::next_type:
        for (Model* each : {&model, frozen_.get()}) {
          const int channel = each == nullptr ? -1 : each->find(view_.selected);
          if (channel >= 0) each->choose_next_type(channel);
        }
        break;
      case Action::stop:
        order(process::EmergencyStop::engage);
        break;
      case Action::release:
        order(process::EmergencyStop::release);
        break;
      case Action::pause:
        view_.paused = !view_.paused;
        if (player_) player_->pause(view_.paused);
        frozen_ = view_.paused ? std::make_unique<Model>(model) : nullptr;
        frozen_at_us_ = around_.now_us;
        break;
    }
    return true;
  }

  SessionOptions options_;
  Surroundings around_;
  View view_;
  lcm_schema::Schema schema_;
  lcm_schema::Decoder decoder_;
  SharedModel shared_;
  std::unique_ptr<Receiver> receiver_;
  std::unique_ptr<Watcher> watcher_;
  std::unique_ptr<LogPlayer> player_;
  std::unique_ptr<process::LcmBus> bus_;  // opened with the first order
  std::unique_ptr<Model> frozen_;
  int64_t frozen_at_us_ = 0;
};

}  // namespace

int run_session(const SessionOptions& options) {
  process::catch_stop_signals();
  return Session(options).run();
}

}  // namespace marco::spy
