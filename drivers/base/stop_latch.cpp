#include "drivers/base/stop_latch.hpp"

#include <algorithm>
#include <fstream>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/state_folder.hpp"

namespace marco::drivers {
namespace {

std::string network_of(const std::string& lcm_url) {
  const std::string url = process::effective_lcm_url(lcm_url);
  const std::string network = url.substr(0, url.find('?'));
  return network == "udpm://" ? "udpm://239.255.76.67:7667" : network;
}

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

StopLatch::StopLatch(const std::string& base, const std::string& lcm_url)
    : path_(process::state_folder("marco") + "/" +
            process::file_name_of("stopped-" + base + "-" + network_of(lcm_url))) {}

std::optional<EmergencyStop> StopLatch::load() const {
  std::error_code unknown;
  if (!std::filesystem::exists(path_, unknown)) return std::nullopt;
  EmergencyStop stop;
  std::ifstream file(path_);
  file >> stop.utime.us;
  file.ignore();
  if (!std::getline(file, stop.sender)) stop.sender = "somebody";
  std::getline(file, stop.reason);
  return stop;
}

void StopLatch::save(const std::optional<EmergencyStop>& stop) const {
  if (!stop) {
    std::filesystem::remove(path_);
    return;
  }
  std::filesystem::create_directories(path_.parent_path());
  files::write_whole_file(path_, std::to_string(stop->utime.us) + "\n" + in_one_line(stop->sender) +
                                     "\n" + in_one_line(stop->reason) + "\n");
}

}  // namespace marco::drivers
