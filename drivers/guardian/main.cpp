#include <fcntl.h>
#include <linux/close_range.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "drivers/guardian/guardian.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/heartbeat.hpp"

namespace {

using namespace marco;           // NOLINT(google-build-using-namespace): a main has no other names
using namespace marco::drivers;  // NOLINT(google-build-using-namespace)

/// Into a cgroup next to the driver's, which may be frozen. Where that is not allowed it stays.
void leave_cgroup() {
  std::string folder, own;
  std::ifstream mounts("/proc/self/mounts"), groups("/proc/self/cgroup");
  for (std::string line; std::getline(mounts, line);) {
    std::string device, path, kind;
    std::istringstream(line) >> device >> path >> kind;
    if (kind == "cgroup2") folder = path;
  }
  for (std::string line; std::getline(groups, line);) {
    if (line.starts_with("0::/")) own = line.substr(3);
  }
  if (folder.empty() || own.empty()) return;
  const std::string beside = folder + std::filesystem::path(own).parent_path().string();
  mkdir((beside + "/marco-guardians").c_str(), 0755);
  std::ofstream(beside + "/marco-guardians/cgroup.procs") << getpid();
}

/// Signals to the driver's session or group are the driver's.
void ignore_signals() {
  for (const int number :
       {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGTTOU, SIGTTIN, SIGTSTP, SIGABRT}) {
    std::signal(number, SIG_IGN);
  }
}

/// Ahead of others, in memory, and last to be killed: each where it is allowed.
void stand_out() {
  const sched_param priority{5};
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) setpriority(PRIO_PROCESS, 0, -10);
  std::ofstream("/proc/self/oom_score_adj") << -1000;
  mlockall(MCL_CURRENT);
}

struct Arguments {
  std::string driver;
  std::string base;
  std::string lcm_url;
};

int guard(const Arguments& arguments) {
  process::start_logging("marco-guardian", "off");  // its driver says the same
  if (fcntl(kGuardianSocket, F_GETFD) < 0 || fcntl(kGuardianMemory, F_GETFD) < 0) {
    throw process::UsageError("only the driver of a base or a pan-tilt starts it");
  }
  if (fork() != 0) _exit(0);  // who kills the driver with its children shall spare this one
  setsid();
  close_range(kGuardianMemory + 1, ~0U, 0);
  ignore_signals();
  FileHandle driver(kGuardianSocket);
  fcntl(kGuardianSocket, F_SETFD, FD_CLOEXEC);
  void* page =
      mmap(nullptr, sizeof(GuardianBeat), PROT_READ | PROT_WRITE, MAP_SHARED, kGuardianMemory, 0);
  if (page == MAP_FAILED) throw std::runtime_error("no shared memory with the driver");
  leave_cgroup();
  std::unique_ptr<EmergencyListener> emergency;
  if (!arguments.base.empty()) {
    emergency = std::make_unique<EmergencyListener>(arguments.base, arguments.lcm_url);
  }
  if (!process::outlive()) throw std::runtime_error("the supervisor would kill it with its driver");
  stand_out();
  Guardian guardian(std::move(driver), *static_cast<GuardianBeat*>(page), std::move(emergency));
  // A terminal that does not take the driver's messages must not hold this process as well.
  const FileHandle nothing(open("/dev/null", O_RDWR | O_CLOEXEC));
  for (const int standard : {0, 1, 2}) dup2(nothing.get(), standard);
  guardian.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-guardian", [&] {
    process::CommandLine app(
        "Stops the device of a driver that hangs or was killed, and keeps a base's emergency "
        "stop.\n"
        "Drivers of bases and pan-tilts start it.");
    Arguments arguments;
    app.add_option("--driver", arguments.driver, "its driver, shown by ps");
    app.add_option("--base", arguments.base, "the base whose emergency stop it keeps");
    process::add_lcm_url(app, arguments.lcm_url);
    if (const auto code = app.parse(argc, argv)) return *code;
    return guard(arguments);
  });
}
