#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/procman/output_log.hpp"
#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {

/// A program of ours, started by a test and ended with it.
class Program {
 public:
  /// @param arguments the program first: a name in the folder MARCO_BIN.
  /// @param output file that gets its stdout and stderr.
  Program(const std::vector<std::string>& arguments, const std::string& output);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const;
  /// @returns its exit code, 128 + signal, or -1 when it has not ended by then.
  int wait_s(double seconds);

 private:
  pid_t pid_ = 0;
  int code_ = -1;
};

/// A deputy and a hand-made sheriff that says exactly what a test wants it to, once.
class ProcmanBench : public testing::Test {
 protected:
  ProcmanBench();
  ~ProcmanBench() override;

  /// Starts a deputy "bench" and waits until it is heard.
  void start_deputy(std::vector<std::string> arguments = {"--accept-any-orders"});
  std::unique_ptr<Program> start_program(std::vector<std::string> arguments);

  /// One PM_ORDERS with all commands ordered so far, this one changed.
  void order(const CommandSpec& spec, int32_t runid, bool force_quit = false);
  void publish_orders(const std::string& sheriff_id = "bench-sheriff");

  /// Hears the bus until `condition`. @returns whether it came true in time.
  bool wait_until(const std::function<bool()>& condition, double seconds = 40.0);
  bool runs(const std::string& id, int32_t runid) const;
  bool has_ended(const std::string& id, int32_t runid) const;
  CommandStatus status(const std::string& id) const;

  /// What the command's file holds now.
  std::string file_of(const std::string& id) const;
  std::string file_of_deputy(const std::string& deputy, const std::string& id) const;
  std::string write_file(const std::string& name, const std::string& text) const;
  std::string programs_output() const;

  std::string folder_;
  std::unique_ptr<process::LcmBus> bus_;
  process::DropCounter drops_;
  std::unique_ptr<Program> deputy_;
  DeputyInfo info_;
  int infos_ = 0;
  std::map<std::string, CommandOrder> orders_;
  std::map<std::string, std::string> output_;  ///< PM_OUTPUT of each command, joined
  OutputLog log_{10};
};

/// Whether the process exists and is no zombie.
bool is_alive(pid_t pid);

}  // namespace marco::procman
