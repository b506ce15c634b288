#include "lcm_tools/relay/program.hpp"
#include "lcmtypes/channels.hpp"

int main(int argc, char** argv) {
  const auto& orders = marco::channels::kRobotOrders;
  return marco::relay::run_relay_program(argc, argv, {orders.begin(), orders.end()});
}
