#include "lcm_tools/relay/program.hpp"

int main(int argc, char** argv) { return marco::relay::run_relay_program(argc, argv, {}); }
