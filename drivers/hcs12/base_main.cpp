#include "drivers/base/base_process.hpp"
#include "drivers/hcs12/base_driver.hpp"

int main(int argc, char** argv) {
  return marco::drivers::base_main<marco::drivers::hcs12::Hcs12Base>(
      argc, argv, "marco-base", "Driver of the HCS12 base of thesis B");
}
