#pragma once

#include <sys/types.h>

#include <string>

namespace marco::procman {

/// A deputy "localhost" inside a sheriff (-l): a child process, which ends with it.
class LoneDeputy {
 public:
  /// Call before there are threads. Looks for marco-procman-deputy beside this program.
  /// @param quiet its messages go nowhere: there is a screen.
  /// @param accept_any_orders it runs what is not in the file, too.
  LoneDeputy(const std::string& config_path,
             const std::string& lcm_url,
             bool quiet,
             bool accept_any_orders = false);

  /// Ends it and all its commands, and waits for that.
  ~LoneDeputy();
  LoneDeputy(const LoneDeputy&) = delete;
  LoneDeputy& operator=(const LoneDeputy&) = delete;

  /// Asks it to end; again: at once.
  void ask_to_end() const;
  bool has_ended();

 private:
  pid_t pid_ = 0;
};

}  // namespace marco::procman
