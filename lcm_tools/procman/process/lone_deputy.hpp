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
  std::string log_path;            ///< gets its messages; "" = this process's own stderr
  bool accept_any_orders = false;  ///< it runs what is not in the file, too
};

/// A deputy "localhost" inside a sheriff (-l): a child process, which ends with it. One that ends
/// without being asked is started again, and finds the commands that still run. The thread that
/// makes it must outlive it.
class LoneDeputy {
 public:
  /// Looks for marco-procman-deputy beside this program.
  explicit LoneDeputy(LoneDeputyOptions options);

  /// Ends it and all its commands, and waits for that.
  ~LoneDeputy();
  LoneDeputy(const LoneDeputy&) = delete;
  LoneDeputy& operator=(const LoneDeputy&) = delete;

  /// Starts it again where it has ended; later each time while it does not live 10 s.
  /// @param now_us monotonic. @returns a line for the event log; "" when nothing happened.
  std::string keep_alive(int64_t now_us);

  /// Asks it to end with all its commands; again: at once. One that dies before that is done is
  /// started once more, a few times, for its commands run on without it.
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
  int last_starts_ = 3;  ///< that are left for stopping the commands
  bool end_is_told_ = false;
  int64_t started_us_ = 0;
  int64_t delay_us_ = 0;
  int64_t start_again_us_ = 0;
};

}  // namespace marco::procman
