#include "drivers/base/base_process.hpp"
#include "drivers/create/driver.hpp"

int main(int argc, char** argv) {
  return marco::drivers::base_main<marco::drivers::create::CreateBase>(
      argc, argv, "marco-create", "Driver of the iRobot Create 2 and Roomba (Open Interface)");
}
