#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "python/scan.hpp"

namespace py = pybind11;

namespace marco::python {
namespace {

Utime now() {
  using namespace std::chrono;
  return Utime::from_us(
      duration_cast<microseconds>(system_clock::now().time_since_epoch()).count());
}

/// What a robot publishes, and orders to its base. One thread uses it; messages are handled while
/// it waits for one.
class Robot {
 public:
  explicit Robot(const std::string& url) : bus_(url), next_id_(now().us) {
    bus_.subscribe<bot_core::planar_lidar_t>(
        channels::kLidarPattern, drops_,
        [this](const auto& message, const process::RawMessage& raw) {
          scan_ = from_message(message, std::string(raw.channel));
        });
    bus_.subscribe<lidar_raw_t>(channels::kLidarRaw, drops_,
                                [this](const auto& message, const process::RawMessage& raw) {
                                  scan_ = from_message(message, std::string(raw.channel));
                                });
    bus_.subscribe<sensor_info_t>(
        channels::kSensorInfo, drops_,
        [this](const auto& message, const auto&) { note_sensor(sensors_, from_message(message)); });
    bus_.subscribe<odometry_t>(
        channels::kOdometry, drops_,
        [this](const auto& message, const auto&) { odometry_ = from_message(message); });
    bus_.subscribe<slam_pose_t>(
        channels::kSlamPose, drops_,
        [this](const auto& message, const auto&) { pose_ = from_message(message); });
    bus_.subscribe<base_status_t>(
        channels::kBaseStatus, drops_,
        [this](const auto& message, const auto&) { base_ = from_message(message); });
  }

  Scan scan(double timeout_s) {
    const LaserScan scan = newest(scan_, timeout_s, "LIDAR or LIDAR_RAW");
    const auto info = sensors_.find(scan.channel);
    return info == sensors_.end()
               ? to_scan(scan, 0.0, kFarthestReturnM)
               : to_scan(scan, info->second.range_min_m, info->second.range_max_m);
  }
  py::tuple odometry(double timeout_s) {
    const OdometrySample sample = newest(odometry_, timeout_s, channels::kOdometry);
    return to_tuple(sample.utime, sample.odom_from_robot);
  }
  py::tuple pose(double timeout_s) {
    const PoseEstimate estimate = newest(pose_, timeout_s, channels::kSlamPose);
    return to_tuple(estimate.utime, estimate.world_from_robot);
  }
  std::string base(double timeout_s) {
    return newest(base_, timeout_s, channels::kBaseStatus).note;
  }

  // A base drives a velocity for kOrderHoldsS: to drive on, the order is given again.
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, double seconds) {
    if (!std::isfinite(velocity_m_per_s) || !std::isfinite(yaw_rate_rad_per_s)) {
      throw std::invalid_argument("a velocity is a finite number");
    }
    BaseCommand order;
    order.kind = BaseCommand::Kind::velocity;
    order.velocity_m_per_s = velocity_m_per_s;
    order.yaw_rate_rad_per_s = yaw_rate_rad_per_s;
    const int64_t end_us = now().us + std::llround(1e6 * seconds);
    give(order);
    while (now().us < end_us) {
      handle_for(std::min(0.4 * kOrderHoldsS, 1e-6 * static_cast<double>(end_us - now().us)));
      if (now().us < end_us) give(order);
    }
    if (seconds > 0.0) stop();
  }
  void go_to(double x_m, double y_m) {
    BaseCommand order;
    order.kind = BaseCommand::Kind::go_to;
    order.point_m = {x_m, y_m};
    give(order);
  }
  void stop() { give({}); }

 private:
  static py::tuple to_tuple(Utime utime, const Pose2& pose) {
    return py::make_tuple(seconds_of(utime), pose.x_m, pose.y_m, pose.theta_rad);
  }

  void give(BaseCommand order) {
    order.utime = now();
    order.id = next_id_++;
    bus_.publish(channels::kBaseCommand, to_message(order));
  }
  // Ctrl-C ends the wait.
  void handle_for(double seconds) {
    const int64_t end_us = now().us + std::llround(1e6 * seconds);
    do {
      {
        const py::gil_scoped_release released;
        bus_.handle_once(20);
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    } while (now().us < end_us);
  }
  // The next message, or one that has come and was not asked for yet.
  template <class Value>
  Value newest(std::optional<Value>& value, double timeout_s, const std::string& channel) {
    handle_for(0.0);
    const int64_t end_us = now().us + std::llround(1e6 * timeout_s);
    while (!value) {
      if (now().us >= end_us) {
        PyErr_SetString(PyExc_TimeoutError, ("nothing came on " + channel).c_str());
        throw py::error_already_set();
      }
      handle_for(0.02);
    }
    Value taken = std::move(*value);
    value.reset();
    return taken;
  }

  process::LcmBus bus_;
  process::DropCounter drops_;
  int64_t next_id_;
  std::map<std::string, SensorInfo> sensors_;
  std::optional<LaserScan> scan_;
  std::optional<OdometrySample> odometry_;
  std::optional<PoseEstimate> pose_;
  std::optional<BaseStatus> base_;
};

}  // namespace

void bind_live(py::module_& module) {
  py::class_<Robot>(module, "Robot")
      .def(py::init<const std::string&>(), py::arg("url") = "")
      .def("scan", &Robot::scan, py::arg("timeout") = 2.0)
      .def("odometry", &Robot::odometry, py::arg("timeout") = 2.0)
      .def("pose", &Robot::pose, py::arg("timeout") = 2.0)
      .def("base", &Robot::base, py::arg("timeout") = 2.0)
      .def("drive", &Robot::drive, py::arg("velocity"), py::arg("yaw_rate") = 0.0,
           py::arg("seconds") = 0.0)
      .def("go_to", &Robot::go_to, py::arg("x"), py::arg("y"))
      .def("stop", &Robot::stop);
}

}  // namespace marco::python
