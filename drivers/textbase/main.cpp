#include "drivers/base/base_process.hpp"
#include "drivers/textbase/driver.hpp"

int main(int argc, char** argv) {
  return marco::drivers::base_main<marco::drivers::textbase::TextBase>(
      argc, argv, "marco-textbase", "Driver of home-made bases that speak Marco's text protocol");
}
