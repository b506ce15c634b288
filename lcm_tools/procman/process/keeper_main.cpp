#include <fcntl.h>
#include <linux/close_range.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <string_view>

#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/version.hpp"
#include "lcm_tools/procman/process/keeper.hpp"

// marco-procman-keeper COMMAND SOCKET-PATH: started by a deputy, with its end of a socket as
// descriptor 3. COMMAND is there for `ps` to show.
int main(int argc, char** argv) {
  using marco::procman::Descriptor;
  const std::string_view asked = argc == 2 ? argv[1] : "";
  if (asked == "--version") {
    std::printf("marco-procman-keeper %s\n", marco::process::version().c_str());
    return marco::process::kExitDone;
  }
  const bool wants_help = asked == "--help" || asked == "-h";
  if (argc != 3) {
    std::fputs("marco-procman-deputy starts marco-procman-keeper, for each command that it runs\n",
               wants_help ? stdout : stderr);
    return wants_help ? marco::process::kExitDone : marco::process::kExitUsage;
  }
  try {
    close_range(4, ~0U, 0);
    const Descriptor nothing(open("/dev/null", O_RDWR | O_CLOEXEC));
    Descriptor deputy(3);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO}) dup2(nothing.get(), standard);
    marco::procman::Keeper keeper(std::move(deputy), argv[2]);
    keeper.start();
    // A pipe at the deputy's stderr must end with the deputy.
    dup2(nothing.get(), STDERR_FILENO);
    keeper.serve();
    return 0;
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "marco-procman-keeper %s: %s\n", argv[1], failure.what());
    return 1;
  }
}
