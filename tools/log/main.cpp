#include "tools/log/extensions.hpp"

int main(int argc, char** argv) {
  return marco::logs::run_log_program(argc, argv, marco::logs::marco_extensions());
}
