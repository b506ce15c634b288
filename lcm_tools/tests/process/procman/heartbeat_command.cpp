#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "lcm_tools/process/heartbeat.hpp"

// A command for the tests of the keeper, which does what its arguments say, in their order:
//   beat SECONDS      with a heartbeat
//   guardian FILE     has a child that outlives it by 2 s and then writes "done" to the file, where
//                     its process id stands before
//   stopping          promises no more beats
//   hang              as a stopped process
int main(int argc, char** argv) {
  using std::chrono::milliseconds;
  marco::process::Heartbeat heartbeat;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "beat") == 0) {
      const auto end = std::chrono::steady_clock::now() +
                       milliseconds(static_cast<int>(std::atof(argv[++i]) * 1000));
      for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(milliseconds(20)))
        heartbeat.beat();
    } else if (std::strcmp(argv[i], "guardian") == 0) {
      const char* file = argv[++i];
      const pid_t parent = getpid();
      if (fork() != 0) continue;
      if (!marco::process::outlive()) return 1;
      std::ofstream(file) << getpid() << std::endl;
      while (getppid() == parent) std::this_thread::sleep_for(milliseconds(20));
      std::this_thread::sleep_for(milliseconds(2000));
      std::ofstream(file) << "done" << std::endl;
      return 0;
    } else if (std::strcmp(argv[i], "stopping") == 0) {
      heartbeat.stopping();
    } else {
      raise(SIGSTOP);
    }
  }
}
