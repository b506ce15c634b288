#include "slam/process/slam_answers.hpp"

#include <algorithm>

namespace marco::slam {

void SlamAnswers::take(const slam_reply_t& reply) {
  constexpr std::size_t kMostSlams = 16;  // anybody may answer
  if (reply.command_utime != order_.utime) return;
  if (answers_.size() >= kMostSlams && !answers_.contains(reply.process)) return;
  answers_[reply.process] = reply;
}

bool SlamAnswers::is_empty() const {
  return std::none_of(answers_.begin(), answers_.end(),
                      [](const auto& one) { return one.second.has_value(); });
}

bool SlamAnswers::are_complete() const {
  return !answers_.empty() && std::all_of(answers_.begin(), answers_.end(),
                                          [](const auto& one) { return one.second.has_value(); });
}

bool SlamAnswers::are_good() const {
  const auto done = [](const auto& one) { return one.second && one.second->ok != 0; };
  const bool one_is_enough =
      order_.command == slam_command_t::LOCALIZE || order_.command == slam_command_t::EXTEND;
  if (one_is_enough) return std::any_of(answers_.begin(), answers_.end(), done);
  return !answers_.empty() && std::all_of(answers_.begin(), answers_.end(), done);
}

std::string SlamAnswers::text() const {
  std::string lines;
  for (const auto& [process, reply] : answers_) {
    if (!lines.empty()) lines += '\n';
    if (answers_.size() > 1 || !reply) lines += process + ": ";
    lines += reply ? reply->text : "no answer";
  }
  return lines;
}

std::string SlamAnswers::path() const {
  for (const auto& [process, reply] : answers_) {
    if (reply && reply->ok != 0 && !reply->path.empty()) return reply->path;
  }
  return "";
}

}  // namespace marco::slam
