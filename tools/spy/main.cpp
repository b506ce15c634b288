#include "lcm_tools/spy/session.hpp"
#include "recordings/recording.hpp"

int main(int argc, char** argv) {
  return marco::spy::run_spy_program(
      argc, argv,
      {[](const std::string& path) { return marco::why_no_log(path); },
       {"To receive messages, run in another terminal:",
        "  ./marco run config/sim.procman drive   a simulated robot (./marco drive)",
        "  ./marco replay LOG                     a recording, in real time",
        "or open a recording: ./marco spy LOG"}});
}
