#include "tools/map/look_ahead.hpp"

#include <algorithm>
#include <map>

#include "common/input/odometry_units.hpp"
#include "recordings/looking_through.hpp"

namespace marco {
namespace {

// Ten times as many as a body needs: a robot that stood by a wall for long has moved on.
constexpr int kEnough = 200;

bool is_on_pantilt(const std::map<std::string, SensorInfo>& sensors, const std::string& channel) {
  const auto info = sensors.find(channel);
  return info != sensors.end() && info->second.mount == SensorInfo::Mount::pantilt;
}

}  // namespace

LookAhead look_ahead(files::SampleReader& recording,
                     const std::filesystem::path& name,
                     const std::vector<BodyPart>& known) {
  LookAhead found;
  OdometryUnits units;
  std::map<std::string, SensorInfo> sensors;
  std::map<std::string, OwnBody> bodies;
  LookingThrough progress(name);
  while (std::optional<Sample> sample = recording.next()) {
    progress.update(recording.progress());
    if (const auto* info = std::get_if<SensorInfo>(&*sample)) note_sensor(sensors, *info);
    if (const auto* odometry = std::get_if<OdometrySample>(&*sample)) {
      found.odometry_fault = units.look(*odometry).value_or("");
    }
    auto* scan = std::get_if<LaserScan>(&*sample);
    if (scan == nullptr || is_on_pantilt(sensors, scan->channel)) continue;
    for (const BodyPart& part : known) {
      if (part.channel == scan->channel) blank(*scan, part);
    }
    bodies[scan->channel].look(*scan);
    if (std::all_of(bodies.begin(), bodies.end(),
                    [](const auto& body) { return body.second.samples() >= kEnough; })) {
      break;
    }
  }
  for (const auto& [channel, body] : bodies) {
    found.body.insert(found.body.end(), body.parts().begin(), body.parts().end());
  }
  return found;
}

}  // namespace marco
