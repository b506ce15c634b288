#include "lcm_tools/tests/process/procman/procman_bench.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {
namespace {

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string program_folder() {
  const char* folder = std::getenv("MARCO_BIN");
  return folder != nullptr ? folder : ".";
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments, const std::string& output) {
  pid_ = fork();
  if (pid_ != 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  const std::string path = program_folder() + "/" + arguments[0];
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) {
    pointers.push_back(const_cast<char*>(argument.c_str()));
  }
  pointers.push_back(nullptr);
  execv(path.c_str(), pointers.data());
  _exit(127);
}

Program::~Program() {
  if (code_ >= 0) return;
  signal(SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void Program::signal(int number) const {
  if (code_ < 0) kill(pid_, number);
}

int Program::wait_s(double seconds) {
  const int64_t end_us = monotonic_us() + static_cast<int64_t>(seconds * 1e6);
  while (code_ < 0) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) {
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    } else if (monotonic_us() > end_us) {
      return -1;
    } else {
      usleep(2000);
    }
  }
  return code_;
}

ProcmanBench::ProcmanBench() {
  std::string pattern = testing::TempDir() + "procman_XXXXXX";
  folder_ = mkdtemp(pattern.data());
  setenv("XDG_RUNTIME_DIR", (folder_ + "/run").c_str(), 1);
  setenv("XDG_STATE_HOME", (folder_ + "/state").c_str(), 1);
  bus_ = std::make_unique<process::LcmBus>("");
  bus_->subscribe<procman_lcm::deputy_info_t>(channels::kInfo, drops_,
                                              [this](const auto& message, const auto&) {
                                                info_ = from_message(message);
                                                ++infos_;
                                              });
  bus_->subscribe<procman_lcm::output_span_t>(
      channels::kOutputSpan, drops_, [this](const auto& message, const auto&) {
        std::vector<OutputSpan> spans;
        for (std::size_t i = 0; i < message.command_ids.size(); ++i) {
          spans.push_back({message.command_ids[i], message.first_bytes[i], message.end_bytes[i],
                           message.files[i]});
        }
        log_.on_span(message.deputy_id, message.utime, std::move(spans));
      });
  bus_->subscribe<procman_lcm::output_t>(
      channels::kOutput, drops_, [this](const auto& message, const auto&) {
        log_.on_output(message.deputy_id, message.utime, message.command_ids, message.text);
        for (std::size_t i = 0; i < message.command_ids.size(); ++i) {
          output_[message.command_ids[i]] += message.text[i];
        }
      });
}

ProcmanBench::~ProcmanBench() {
  if (deputy_) {
    deputy_->signal(SIGTERM);
    deputy_->signal(SIGTERM);
    deputy_->wait_s(5.0);
    if (HasFailure()) std::cerr << programs_output();
  }
  std::filesystem::remove_all(folder_);
}

void ProcmanBench::start_deputy(std::vector<std::string> arguments) {
  std::vector<std::string> all = {"marco-procman-deputy", "-i", "bench"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  infos_ = 0;
  deputy_ = start_program(all);
  ASSERT_TRUE(wait_until([&] { return infos_ > 0; })) << "the deputy was not heard";
}

std::unique_ptr<Program> ProcmanBench::start_program(std::vector<std::string> arguments) {
  return std::make_unique<Program>(arguments, folder_ + "/programs.log");
}

void ProcmanBench::order(const CommandSpec& spec, int32_t runid, bool force_quit) {
  orders_[spec.id] = {spec, runid, force_quit};
  publish_orders();
}

void ProcmanBench::publish_orders(const std::string& sheriff_id) {
  Orders orders{wall_clock_us(), "bench", sheriff_id, {}};
  for (const auto& [id, order] : orders_) orders.commands.push_back(order);
  bus_->publish(channels::kOrders, to_message(orders));
}

bool ProcmanBench::wait_until(const std::function<bool()>& condition, double seconds) {
  const int64_t end_us = monotonic_us() + static_cast<int64_t>(seconds * 1e6);
  while (!condition()) {
    if (monotonic_us() > end_us) return false;
    bus_->handle_once(5);
  }
  return true;
}

CommandStatus ProcmanBench::status(const std::string& id) const {
  for (const CommandStatus& command : info_.commands) {
    if (command.spec.id == id) return command;
  }
  return {};
}

bool ProcmanBench::runs(const std::string& id, int32_t runid) const {
  return status(id).pid != 0 && status(id).actual_runid == runid;
}

bool ProcmanBench::has_ended(const std::string& id, int32_t runid) const {
  return !status(id).spec.id.empty() && status(id).pid == 0 && status(id).actual_runid == runid;
}

std::string ProcmanBench::file_of(const std::string& id) const {
  return file_of_deputy("bench", id);
}

std::string ProcmanBench::file_of_deputy(const std::string& deputy, const std::string& id) const {
  return contents(folder_ + "/state/marco-procman/" + deputy + "/" + id + ".log");
}

std::string ProcmanBench::write_file(const std::string& name, const std::string& text) const {
  std::ofstream(folder_ + "/" + name) << text;
  return folder_ + "/" + name;
}

std::string ProcmanBench::programs_output() const { return contents(folder_ + "/programs.log"); }

bool is_alive(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  return std::getline(file, line) && line.substr(line.rfind(')') + 2, 1) != "Z";
}

}  // namespace marco::procman
