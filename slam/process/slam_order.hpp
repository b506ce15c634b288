#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "common/pose2.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_reply_t.hpp"
#include "slam/process/background_job.hpp"

namespace marco::slam {

/// A SLAM_COMMAND that was checked, for both SLAMs: nothing is changed before that.
struct SlamOrder {
  int8_t command = 0;            ///< as slam_command_t::command
  std::filesystem::path folder;  ///< SAVE, LOCALIZE, EXTEND: below the folder for maps
  Pose2 world_from_robot;        ///< SET_POSE
};

/// @param maps_folder  where SAVE, LOCALIZE and EXTEND are allowed; "" = nowhere
/// @throws std::invalid_argument naming the command and saying what is wrong with it.
SlamOrder check_order(const slam_command_t& command, const std::filesystem::path& maps_folder);

/// Takes SLAM_COMMANDs for either SLAM and answers each. Not thread-safe.
class SlamOrders {
 public:
  /// @param drops  counts those that were refused or failed; outlives this
  explicit SlamOrders(process::DropCounter& drops) : drops_(drops) {}

  /// From here on no scan waits for a map to be written.
  void write_in_background() { in_background_ = true; }

  /// Checks the command, has `execute` do it, and keeps what that says, or why it was refused or
  /// failed. An order that is stale when it comes (why_stale) is refused: a recording's order must
  /// not erase today's map. @param came  live: its arrival; batch: its event time
  /// @param execute  throws std::invalid_argument to refuse, before it changes anything
  void take(const slam_command_t& command,
            Utime came,
            const std::filesystem::path& maps_folder,
            const std::function<std::string(const SlamOrder&)>& execute);
  /// For SAVE. @param job  writes, and says what it wrote. @returns that, or in the background "".
  /// @throws std::invalid_argument while the map before is still being written.
  std::string write(std::function<std::string()> job);
  /// The result of the oldest unreported order, without `utime` and `process`.
  std::optional<slam_reply_t> take_reply();
  /// Until nothing is being written.
  void wait();

 private:
  void answer(const slam_reply_t& order, const std::function<std::string()>& act);
  void settle_writing(bool wait);

  process::DropCounter& drops_;
  std::deque<slam_reply_t> answers_;
  slam_reply_t taking_ = {};   ///< of the order being executed
  slam_reply_t written_ = {};  ///< of the map being written
  BackgroundJob writing_;
  bool in_background_ = false;
};

/// Publishes the reply on SLAM_REPLY as from `process`. @returns its text for the log; "" = none.
std::string publish_reply(process::Bus& bus,
                          const char* process,
                          std::optional<slam_reply_t> reply);

}  // namespace marco::slam
