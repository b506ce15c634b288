#include "lcm_tools/spy/session.hpp"

int main(int argc, char** argv) { return marco::spy::run_spy_program(argc, argv, {}); }
