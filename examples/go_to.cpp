// Sends the robot to a point of its odometry's frame and waits until it is there.   go_to X Y
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: go_to X Y   (metres)\n"), 2;
  using namespace std::chrono;
  marco::BaseCommand order;
  order.utime = marco::Utime::from_us(
      duration_cast<microseconds>(system_clock::now().time_since_epoch()).count());
  order.id = order.utime.us;  // anything above 0 that nobody else uses: the base's answer names it
  order.kind = marco::BaseCommand::Kind::go_to;
  order.point_m = {std::atof(argv[1]), std::atof(argv[2])};

  marco::process::LcmBus bus("");
  marco::process::DropCounter drops;
  std::optional<marco::BaseStatus> answer;
  bus.subscribe<marco::base_status_t>(marco::channels::kBaseStatus, drops,
                                      [&](const auto& message, const auto&) {
                                        const marco::BaseStatus status = from_message(message);
                                        if (status.command_id == order.id) answer = status;
                                      });
  bus.publish(marco::channels::kBaseCommand, to_message(order));

  using Command = marco::BaseStatus::Command;
  const auto give_up = steady_clock::now() + minutes(2);
  while (!answer || answer->command == Command::running) {
    bus.handle_once(100);
    if (!answer && steady_clock::now() > give_up - seconds(117))
      return std::puts("no base answers"), 1;
    if (steady_clock::now() > give_up) return std::puts("not there after two minutes"), 1;
  }
  const bool there = answer->command == Command::done;
  std::printf("%s %s\n", there ? "there" : "not there:", answer->note.c_str());
  return there ? 0 : 1;
}
