#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace marco::web {

/// What is wrong, and what to do about it.
struct HealthFinding {
  bool is_error = false;
  std::string text, remedy;
};

struct ChannelHealth {
  std::string name, type;
  double hz = 0.0;
  int64_t lost = 0;  ///< messages, since the page listens
  double age_s = 0.0;
};

/// Inputs of the page's health, besides Health's own state.
struct Surroundings {
  std::vector<ChannelHealth> channels;
  std::vector<HealthFinding> findings;
  int64_t clients = 0, refused = 0, dropped = 0;
};

/// The programs that say how they are, the base's batteries, and SLAM's latency, as page/health. It
/// has no clock: times are [us] of any clock that never steps back, but for stamps.
class Health {
 public:
  /// Of PROCESS_STATUS. @param dropped  by all causes, since the program's start
  void take_status(const std::string& program,
                   const std::string& state,
                   int64_t dropped,
                   int64_t now_us);
  /// It was stopped, or is done: that it says no more is no fault.
  void forget(const std::string& program) { programs_.erase(program); }
  void take_base(const std::string& base,
                 bool is_link_up,
                 const std::vector<double>& battery_v,
                 const std::string& note,
                 int64_t now_us);
  /// A scan of SLAM's pose was measured so long ago. Ages of other clocks are ignored.
  void take_pose_age(double age_s, int64_t now_us);

  /// @param utime_us  the message's stamp
  std::string json(const Surroundings& around, int64_t utime_us, int64_t now_us) const;

 private:
  struct Program {
    std::string state;
    int64_t dropped = 0;
    int64_t dropped_us = 0;  // when that last grew
    int64_t heard_us = 0;
  };
  struct Base {
    std::string name, note, guard;
    bool is_link_up = true;
    std::vector<double> battery_v;
    int64_t heard_us = 0;
  };
  std::string word_of(const Program& program, int64_t now_us) const;
  std::vector<HealthFinding> own_findings(int64_t now_us) const;

  std::map<std::string, Program> programs_;
  std::optional<Base> base_;
  double latency_s_ = 0.0;
  int64_t latency_us_ = 0;  // when that was measured; 0 = never
};

}  // namespace marco::web
