#include "web/process/slam_calls.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_reply_t.hpp"
#include "web/process/request_fields.hpp"

namespace marco::web {
namespace {

constexpr int64_t kAnswersWithinUs = 10'000'000;
constexpr int64_t kSpokeWithinUs = 3'000'000;  // a SLAM that runs does so once a second

const std::map<std::string, int8_t>& commands() {
  static const std::map<std::string, int8_t> kAll = {
      {"save", slam_command_t::SAVE},         {"reset", slam_command_t::RESET},
      {"set_pose", slam_command_t::SET_POSE}, {"localize", slam_command_t::LOCALIZE},
      {"pause", slam_command_t::PAUSE},       {"resume", slam_command_t::RESUME},
      {"extend", slam_command_t::EXTEND}};
  return kAll;
}

slam_command_t command_of(std::string_view json) {
  const Json request = parsed(json);
  const std::string word = text_of(request, "command");
  const auto known = commands().find(word);
  require(known != commands().end(), "SLAM has no order '" + word.substr(0, 40) + "'");
  slam_command_t command{};
  command.command = known->second;
  command.folder = text_of(request, "folder");
  require(files::stays_inside(command.folder),
          "a map's folder is a name below the folder for maps");
  command.x_m = number_of(request, "x_m");
  command.y_m = number_of(request, "y_m");
  command.theta_rad = number_of(request, "theta_rad");
  return command;
}

}  // namespace

SlamCalls::SlamCalls(const Source& source, Answer answer)
    : bus_(source.live), answer_(std::move(answer)) {
  source.in.subscribe<slam_reply_t>(channels::kSlamReply, source.drops,
                                    [this](const slam_reply_t& reply, const auto&) {
                                      const auto waiting = waiting_.find(reply.command_utime);
                                      if (waiting == waiting_.end()) return;
                                      waiting->second.answers.take(reply);
                                      if (waiting->second.answers.are_complete())
                                        waiting->second.until_us = 0;
                                    });
  source.in.subscribe<process_status_t>(channels::kProcessStatus, source.drops,
                                        [this](const process_status_t& status, const auto&) {
                                          if (!slam::is_slam(status.process)) return;
                                          slams_heard_us_[status.process] = procman::monotonic_us();
                                        });
}

slam_command_t SlamCalls::send(slam_command_t command) {
  // Replies name the order by its stamp.
  command.utime = last_utime_us_ = std::max(process::wall_clock_us(), last_utime_us_ + 1);
  bus_->publish(channels::kSlamCommand, command);
  return command;
}

void SlamCalls::order(const Hub::Call& call, std::string_view json) {
  const slam_command_t command = command_of(json);
  constexpr std::size_t kMostWaiting = 100;
  require(waiting_.size() < kMostWaiting, "too many orders to SLAM are waiting for their answers");
  const slam_command_t sent = send(command);
  const int64_t now_us = procman::monotonic_us();
  slam::SlamAnswers answers(sent);
  for (const auto& [process, heard_us] : slams_heard_us_) {
    if (now_us - heard_us < kSpokeWithinUs) answers.expect(process);
  }
  waiting_.insert_or_assign(sent.utime, Waiting{call, answers, now_us + kAnswersWithinUs});
}

void SlamCalls::step(int64_t now_us) {
  for (auto waiting = waiting_.begin(); waiting != waiting_.end();) {
    if (now_us < waiting->second.until_us) {
      ++waiting;
      continue;
    }
    answer_(waiting->second.call, waiting->second.answers);
    waiting = waiting_.erase(waiting);
  }
}

}  // namespace marco::web
