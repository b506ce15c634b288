#include "drivers/base/base_process.hpp"
#include "drivers/p2os/driver.hpp"

int main(int argc, char** argv) {
  return marco::drivers::base_main<marco::drivers::p2os::P2osBase>(
      argc, argv, "marco-p2os", "Driver of ActivMedia Pioneer robots (P2OS, ARCOS)");
}
