#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "lcm_tools/process/bus.hpp"
#include "marco/slam_command_t.hpp"
#include "slam/process/slam_answers.hpp"
#include "web/hub.hpp"
#include "web/process/source.hpp"

namespace marco::web {

/// Calls of the service slam: each becomes a SLAM_COMMAND, and is answered once every SLAM that
/// runs has answered that, or after 10 s. One thread.
class SlamCalls {
 public:
  using Answer = std::function<void(const Hub::Call& call, const slam::SlamAnswers& answers)>;

  /// @param source  outlives it. @param answer  gets none where no SLAM has answered
  SlamCalls(const Source& source, Answer answer);

  /// Live only. @throws std::invalid_argument saying what is wrong with the request.
  void order(const Hub::Call& call, std::string_view json);
  /// Live only; nobody waits for an answer. @returns the order as it was stamped and sent.
  slam_command_t send(slam_command_t command);
  /// Call often. @param now_us  monotonic
  void step(int64_t now_us);

 private:
  struct Waiting {
    Hub::Call call;
    slam::SlamAnswers answers;
    int64_t until_us = 0;
  };

  process::Bus* bus_;
  Answer answer_;
  std::map<int64_t, Waiting> waiting_;             // by the order's utime
  std::map<std::string, int64_t> slams_heard_us_;  // by process, monotonic
  int64_t last_utime_us_ = 0;
};

}  // namespace marco::web
