#include "posts/posts_input.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/files/tum.hpp"
#include "lcm_tools/base/check.hpp"
#include "posts/csv_table.hpp"

namespace marco {
namespace {

CsvTable table_of(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (const auto path = find_csv(folder, name)) return read_csv(*path);
  }
  std::string wanted;
  for (const std::string& name : names) wanted += (wanted.empty() ? "" : " or ") + name + ".csv";
  throw std::invalid_argument(folder.string() + ": contains no " + wanted + ", plain or .gz");
}

Utime time_of(const std::vector<double>& row, std::size_t column) {
  return Utime::from_seconds(row[column]);
}

std::vector<slam::WheelVelocity> wheels_of(const CsvTable& table, const CarOptions& car) {
  const std::size_t time = table.index_of("time_s"), speed = table.index_of("speed_mps");
  const auto steering = table.find("steering_rad");
  const std::size_t turn = steering ? *steering : table.index_of("turn_rate_radps");
  require(!steering || car.wheelbase_m > 0.0,
          table.path.string() + ": has a steering angle; give car.wheelbase_m in the config");
  std::vector<slam::WheelVelocity> wheels;
  for (const auto& row : table.rows) {
    slam::WheelVelocity sample{time_of(row, time), row[speed], row[turn]};
    if (steering) {
      const double bend_per_m = std::tan(row[turn]) / car.wheelbase_m;
      sample.speed_m_per_s = row[speed] / (1.0 - bend_per_m * car.speed_wheel_left_m);
      sample.turn_rate_rad_per_s = sample.speed_m_per_s * bend_per_m;
    }
    wheels.push_back(sample);
  }
  std::stable_sort(wheels.begin(), wheels.end(),
                   [](const auto& a, const auto& b) { return a.utime < b.utime; });
  return wheels;
}

// scans.csv names the scans that saw nothing, too; without it they are not known.
std::vector<slam::SightingScan> scans_of(const std::filesystem::path& folder) {
  const CsvTable table = table_of(folder, {"sightings", "posts", "trees"});
  const std::size_t time = table.index_of("time_s"), range = table.index_of("range_m"),
                    bearing = table.index_of("bearing_rad");
  const auto diameter = table.find("diameter_m");
  std::map<int64_t, std::vector<slam::Sighting>> by_time;
  if (const auto path = find_csv(folder, "scans")) {
    const CsvTable scans = read_csv(*path);
    const std::size_t scan_time = scans.index_of("time_s");
    for (const auto& row : scans.rows) by_time[time_of(row, scan_time).us];
  }
  for (const auto& row : table.rows) {
    by_time[time_of(row, time).us].push_back(
        {row[range], row[bearing], diameter ? row[*diameter] : 0.0});
  }
  std::vector<slam::SightingScan> scans;
  for (auto& [us, sightings] : by_time) scans.push_back({Utime::from_us(us), std::move(sightings)});
  return scans;
}

void read_truth(const std::filesystem::path& folder, PostsInput& input) {
  if (std::filesystem::exists(folder / "truth.tum")) {
    input.truth_file = "truth.tum";
    input.truth = files::read_tum(folder / "truth.tum");
    return;
  }
  const auto truth = find_csv(folder, "truth");
  const auto path = truth ? truth : find_csv(folder, "gps");
  if (!path) return;
  input.truth_file = path->filename();
  input.truth_is_gps = !truth;
  const CsvTable table = read_csv(*path);
  const std::size_t time = table.index_of("time_s");
  const std::size_t x = table.index_of(truth ? "x_m" : "east_m");
  const std::size_t y = table.index_of(truth ? "y_m" : "north_m");
  for (const auto& row : table.rows) input.truth.push_back({time_of(row, time), {row[x], row[y]}});
}

}  // namespace

PostsInput read_posts_folder(const std::filesystem::path& folder, const CarOptions& car) {
  PostsInput input;
  input.drive.wheels = wheels_of(table_of(folder, {"drive"}), car);
  input.drive.scans = scans_of(folder);
  require(!input.drive.wheels.empty(), folder.string() + ": its drive is empty");
  require(!input.drive.scans.empty(), folder.string() + ": contains no scans");
  read_truth(folder, input);
  std::stable_sort(input.truth.begin(), input.truth.end(),
                   [](const auto& a, const auto& b) { return a.utime < b.utime; });
  return input;
}

}  // namespace marco
