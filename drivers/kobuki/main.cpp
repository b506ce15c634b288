#include "drivers/base/base_process.hpp"
#include "drivers/kobuki/driver.hpp"

int main(int argc, char** argv) {
  return marco::drivers::base_main<marco::drivers::kobuki::KobukiBase>(
      argc, argv, "marco-kobuki", "Driver of Yujin Robot's Kobuki (TurtleBot 2), with its gyro");
}
