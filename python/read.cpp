#include <pybind11/stl.h>

#include "python/scan.hpp"
#include "recordings/recording.hpp"

namespace py = pybind11;

namespace marco::python {
namespace {

/// A recording in memory.
struct Recording {
  std::vector<Scan> scans;
  py::array_t<double> odometry;
  py::array_t<double> imu;
  py::array_t<double> truth;
  std::string format;
  std::map<std::string, int64_t> dropped;
  std::vector<std::string> notes;
};

struct Samples {
  std::map<std::string, SensorInfo> sensors;
  std::vector<LaserScan> scans;
  Trajectory odometry;
  std::vector<ImuSample> imu;
  Trajectory truth;

  void take(SensorInfo&& info) { note_sensor(sensors, info); }
  void take(LaserScan&& scan) { scans.push_back(std::move(scan)); }
  void take(OdometrySample&& sample) { odometry.push_back({sample.utime, sample.odom_from_robot}); }
  void take(ImuSample&& sample) { imu.push_back(sample); }
  void take(PanTiltState&&) {}
  void take(TruePose&& pose) { truth.push_back({pose.utime, pose.world_from_robot}); }
};

Recording read(const std::string& path) {
  Samples samples;
  Recording recording;
  {
    const py::gil_scoped_release released;
    const auto reader = open_recording(path);
    while (auto sample = reader->next()) {
      std::visit([&](auto& value) { samples.take(std::move(value)); }, *sample);
    }
    recording.format = reader->report().format;
    recording.dropped = reader->report().dropped;
    recording.notes = reader->report().notes;
  }
  for (const LaserScan& scan : samples.scans) {
    const auto info = samples.sensors.find(scan.channel);
    const bool known = info != samples.sensors.end();
    recording.scans.push_back(to_scan(scan, known ? info->second.range_min_m : 0.0,
                                      known ? info->second.range_max_m : kFarthestReturnM));
  }
  recording.odometry = to_array(samples.odometry);
  recording.truth = to_array(samples.truth);
  recording.imu = table(samples.imu.size(), 7, [&](std::size_t i, double* row) {
    const ImuSample& sample = samples.imu[i];
    row[0] = seconds_of(sample.utime);
    for (int axis = 0; axis < 3; ++axis) {
      row[1 + axis] = sample.angular_velocity_rad_per_s[axis];
      row[4 + axis] = sample.acceleration_m_per_s2[axis];
    }
  });
  return recording;
}

}  // namespace

void bind_read(py::module_& module) {
  py::class_<Recording>(module, "Recording")
      .def_readonly("scans", &Recording::scans)
      .def_readonly("odometry", &Recording::odometry)
      .def_readonly("imu", &Recording::imu)
      .def_readonly("truth", &Recording::truth)
      .def_readonly("format", &Recording::format)
      .def_readonly("dropped", &Recording::dropped)
      .def_readonly("notes", &Recording::notes);
  module.def("_read", &read, py::arg("path"));
}

}  // namespace marco::python
