#pragma once

#include <map>
#include <optional>
#include <string>

#include "marco/slam_command_t.hpp"
#include "marco/slam_reply_t.hpp"

namespace marco::slam {

/// Whether a program of this name takes SLAM_COMMAND.
inline bool is_slam(const std::string& process) {
  return process == "marco-slam" || process == "marco-line-slam";
}

/// The answers to one SLAM_COMMAND. Every SLAM that runs obeys it and answers; both may run, and
/// one may refuse what the other does.
class SlamAnswers {
 public:
  /// @param order  as sent: answers name it by its utime
  explicit SlamAnswers(const slam_command_t& order) : order_(order) {}

  /// This SLAM runs: its answer is waited for.
  void expect(const std::string& process) { answers_.try_emplace(process); }
  /// Replies to other orders are ignored.
  void take(const slam_reply_t& reply);

  bool is_empty() const;
  /// Each SLAM that runs has answered, and one at least.
  bool are_complete() const;
  /// Each SLAM that runs has done it. To look for the robot in a saved map, one of them is enough:
  /// line SLAM cannot.
  bool are_good() const;
  /// One line for each SLAM, with its name where there are several; says which did not answer.
  std::string text() const;
  /// The folder, see slam_reply_t.
  std::string path() const;

 private:
  slam_command_t order_;
  std::map<std::string, std::optional<slam_reply_t>> answers_;  // by process
};

}  // namespace marco::slam
