#include "lcm_tools/procman/process/lone_deputy.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <utility>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kHealthyUs = 10'000'000;
constexpr int64_t kLongestDelayUs = 30'000'000;
constexpr std::uintmax_t kMaxLogBytes = 1U << 20;
const std::string kName = std::string("deputy ") + kLoneDeputyId;

Descriptor open_log(const std::string& path) {
  if (path.empty()) return Descriptor(dup(STDERR_FILENO));
  std::error_code none;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), none);
  const auto size = std::filesystem::file_size(path, none);
  if (!none && size > kMaxLogBytes) std::filesystem::rename(path, path + ".1", none);
  Descriptor log(open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  return log.is_open() ? std::move(log) : Descriptor(open("/dev/null", O_WRONLY | O_CLOEXEC));
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> environment_with(const std::string& lcm_url) {
  const std::string key = "LCM_DEFAULT_URL=";
  std::vector<std::string> all;
  for (char** at = environ; *at != nullptr; ++at) {
    if (lcm_url.empty() || !std::string(*at).starts_with(key)) all.emplace_back(*at);
  }
  if (!lcm_url.empty()) all.push_back(key + lcm_url);
  return all;
}

}  // namespace

LoneDeputy::LoneDeputy(LoneDeputyOptions options) : options_(std::move(options)) {
  start(monotonic_us());
}

void LoneDeputy::start(int64_t now_us) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "marco-procman-deputy";
  std::vector<std::string> arguments = {program, "-i", kLoneDeputyId, "--script",
                                        options_.config_path};
  if (options_.accept_any_orders) arguments.emplace_back("--accept-any-orders");
  std::vector<std::string> environment = environment_with(options_.lcm_url);
  const std::vector<char*> argument_pointers = pointers_to(arguments);
  const std::vector<char*> environment_pointers = pointers_to(environment);
  const Descriptor log = open_log(options_.log_path);
  const Descriptor nothing(open("/dev/null", O_RDWR | O_CLOEXEC));
  const pid_t parent = getpid();
  end_is_told_ = false;
  raw_status_ = 0;
  started_us_ = now_us;
  pid_ = fork();
  if (pid_ < 0) throw_errno("fork");
  if (pid_ > 0) return;
  // Only system calls here: LCM's threads are not in the child. Stop signals stay blocked, so that
  // one that comes early waits until the deputy reads it.
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  setpgid(0, 0);  // a ^C at the terminal is the sheriff's to handle
  dup2(nothing.get(), STDIN_FILENO);
  dup2(log.get(), STDERR_FILENO);
  if (!options_.log_path.empty()) dup2(log.get(), STDOUT_FILENO);
  execve(argument_pointers[0], argument_pointers.data(), environment_pointers.data());
  _exit(127);
}

std::string LoneDeputy::messages_are_in() const {
  return options_.log_path.empty() ? "" : "; its messages are in " + options_.log_path;
}

std::string LoneDeputy::keep_alive(int64_t now_us) {
  if (asked_to_end_ || !is_gone()) return "";
  if (!std::exchange(end_is_told_, true)) {
    const bool was_healthy = now_us - started_us_ > kHealthyUs;
    delay_us_ = was_healthy ? 0 : std::clamp<int64_t>(2 * delay_us_, 500'000, kLongestDelayUs);
    start_again_us_ = now_us + delay_us_;
    return kName + " has ended: " + describe_exit(raw_status_) +
           "; its commands keep running, and it restarts" + messages_are_in();
  }
  if (now_us < start_again_us_) return "";
  start(now_us);
  return kName + " restarts and takes over the commands that still run";
}

void LoneDeputy::ask_to_end() {
  if (is_gone() && !asked_to_end_) start(monotonic_us());
  asked_to_end_ = true;
  if (pid_ > 0) kill(pid_, SIGTERM);
}

bool LoneDeputy::is_gone() {
  if (pid_ > 0 && waitpid(pid_, &raw_status_, WNOHANG) == pid_) pid_ = 0;
  return pid_ == 0;
}

bool LoneDeputy::has_ended() {
  if (!is_gone()) return false;
  if (!asked_to_end_ || ended_well() || last_starts_ == 0) return true;
  --last_starts_;
  start(monotonic_us());
  kill(pid_, SIGTERM);
  return false;
}

LoneDeputy::~LoneDeputy() {
  if (!asked_to_end_) ask_to_end();
  while (!has_ended()) usleep(20'000);
}

}  // namespace marco::procman
