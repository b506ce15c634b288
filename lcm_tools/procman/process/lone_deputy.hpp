#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace marco::procman {

/// The id of the deputy that a sheriff brings along (-l).
inline constexpr const char* kLoneDeputyId = "localhost";

struct LoneDeputyOptions {
  std::string config_path;
  std::string lcm_url;             ///< "" = LCM_DEFAULT_URL, or the common default
  std::string log_path;            ///< of its messages; "" = this process's stderr
  bool accept_any_orders = false;  ///< also commands that are not in the file
};

/// The deputy "localhost" of a sheriff (-l): a child process that ends with it. If it dies, it is
/// started again and finds the commands that still run. The thread that makes it must outlive it.
class LoneDeputy {
 public:
  /// Expects marco-procman-deputy in this program's folder.
  explicit LoneDeputy(LoneDeputyOptions options);

  /// Ends it and all its commands, and waits for that.
  ~LoneDeputy();
  LoneDeputy(const LoneDeputy&) = delete;
  LoneDeputy& operator=(const LoneDeputy&) = delete;

  /// Starts it again when it has ended, with growing delays while its lives are shorter than 10 s.
  /// @param now_us monotonic. @returns a line for the event log; "" when nothing happened.
  std::string keep_alive(int64_t now_us);

  /// Asks it to end with all its commands; a second time: at once. If it dies before that is done
  /// it is started again, a few times, because its commands would keep running.
  void ask_to_end();
  bool has_ended();

  /// After has_ended(): whether it has stopped all its commands.
  bool ended_well() const { return raw_status_ == 0; }

 private:
  void start(int64_t now_us);
  bool is_gone();
  std::string messages_are_in() const;

  LoneDeputyOptions options_;
  pid_t pid_ = 0;
  int raw_status_ = 0;
  bool asked_to_end_ = false;
  int last_starts_ = 3;  ///< left, for stopping the commands
  bool end_is_told_ = false;
  int64_t started_us_ = 0;
  int64_t delay_us_ = 0;
  int64_t start_again_us_ = 0;
};

}  // namespace marco::procman
