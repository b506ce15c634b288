#include "web/process/recording.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>

#include "lcm_tools/log/moment.hpp"
#include "lcm_tools/log/output_file.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "recordings/import_recording.hpp"

namespace marco::web {
namespace {

namespace fs = std::filesystem;

constexpr int kLongestWaitMs = 50;
constexpr Duration kLongestSilence = Duration::from_us(5'000'000);

bool is_lcm_log(const fs::path& path) {
  if (fs::is_directory(path)) return false;
  try {
    logs::span_of_log(path);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

}  // namespace

Recording::Recording(const fs::path& path, double speed) {
  fs::path played = path;
  if (!is_lcm_log(path)) {
    played = fs::temp_directory_path() / ("marco-page-" + std::to_string(getpid()) + ".lcm");
    spdlog::info("reading {}", path.string());
    logs::OutputFile out(played, logs::Existing::refuse, {path});
    logs::import_recording(path, out, [](double) {});
    out.finish();
  }
  logs::PlayerOptions options;
  options.speed = speed;
  options.loop = true;
  options.longest_wait = kLongestSilence;
  player_ = std::make_unique<logs::Player>(
      played, logs::ChannelChoice(), options,
      [this](const std::string& channel, std::span<const uint8_t> bytes, Utime event_time) {
        bus_.deliver(channel, bytes, event_time);
        return true;
      });
  if (played != path) fs::remove(played);  // the player has it open
}

void Recording::serve(Hub& hub) {
  hub_ = &hub;
  hub.on_playback = [this](Hub::ClientId, const foxglove::PlaybackControl& asked) {
    control(asked);
  };
}

int Recording::advance(int64_t now_us) {
  const auto due_us = player_->advance(now_us);
  if (!due_us) return kLongestWaitMs;
  return static_cast<int>(std::clamp<int64_t>((*due_us - now_us) / 1000, 0, kLongestWaitMs));
}

void Recording::control(const foxglove::PlaybackControl& control) {
  constexpr double kSlowest = 0.01, kFastest = 1000.0;
  const int64_t now_us = procman::monotonic_us();
  player_->set_speed(std::clamp(control.speed, kSlowest, kFastest), now_us);
  if (control.seek_ns) {
    const Utime wanted = Utime::from_us(*control.seek_ns / 1000);
    player_->seek(std::clamp(wanted, span().first, span().last), now_us);
  }
  player_->set_paused(!control.play, now_us);
  foxglove::PlaybackState state;
  state.is_playing = control.play;
  state.did_seek = control.seek_ns.has_value();
  state.time_ns = position().us * 1000;
  state.speed = player_->speed();
  state.request = std::string(control.request);
  hub_->broadcast(foxglove::playback_state(state));
}

}  // namespace marco::web
