#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/pose2.hpp"
#include "common/robot_values.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::web {

struct SteeringOptions {
  double most_velocity_m_per_s = 0.5;
  double most_yaw_rate_deg_per_s = 60.0;
  double goal_velocity_m_per_s = 0.12;

  template <class Visitor>
  void visit(Visitor& v) {
    v("most_velocity_m_per_s", most_velocity_m_per_s, kPositive,
      "A browser's stick drives no faster than this. Less where people walk.");
    v("most_yaw_rate_deg_per_s", most_yaw_rate_deg_per_s, kPositive,
      "A browser's stick turns no faster than this.");
    v("goal_velocity_m_per_s", goal_velocity_m_per_s, kPositive,
      "A drive to a place is no faster than this. When its browser disconnects, a base that brakes "
      "at 0.3 m/s2 stands within a second; at a higher speed, later.");
  }
};

/// A velocity as a client asks for it.
struct Velocity {
  double m_per_s = 0.0, rad_per_s = 0.0;
  bool is_rest() const { return m_per_s == 0.0 && rad_per_s == 0.0; }
};
/// {"linear":{"x"},"angular":{"z"}}, or the same as `twist` of a stamped one.
/// @throws std::invalid_argument for text that is no such JSON, and numbers that are not finite.
Velocity parse_twist(std::string_view json);

struct FramedPose {
  std::string frame;  ///< "map" or "odom"
  Pose2 pose;
};
/// A PoseStamped, or a PoseWithCovarianceStamped. No frame means the map's.
/// @throws std::invalid_argument as above, and for other frames.
FramedPose parse_pose(std::string_view json);

/// Turns what clients ask into orders to the base. The driving client has the stick until half a
/// second after the last velocity; others are refused meanwhile. Velocities are passed on 20 times
/// a second at most, the newest counts. Pure.
class Steering {
 public:
  using Client = uint64_t;

  explicit Steering(const SteeringOptions& options);

  /// @throws std::invalid_argument saying why not, for the client.
  void drive(Client client, Velocity velocity, Utime now);
  /// A client is gone: what it drove stops.
  void forget(Client client, Utime now);
  /// Something else drives from here on: the stick is nobody's.
  void let_go();
  /// Of the next order.
  int64_t next_id(Utime now);
  /// With its stamp and id.
  BaseCommand order(BaseCommand command, Utime now);

  /// Call often. @returns what is to be sent now.
  std::optional<BaseCommand> due(Utime now);

 private:
  SteeringOptions options_;
  Client driver_ = 0;  // 0 = nobody drives
  Utime heard_;        // from the driver
  std::optional<Velocity> waiting_;
  bool stop_waits_ = false;
  Utime sent_;
  int64_t id_ = 0;
};

}  // namespace marco::web
