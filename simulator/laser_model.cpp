#include "simulator/laser_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::sim {

LaserModel::LaserModel(const RayCaster& rays, const LaserOptions& options)
    : rays_(rays), options_(options) {
  validate(options, "laser");
  require(options.step_deg != 0.0, "laser.step_deg: expected other than 0");
}

LaserModel::Legs LaserModel::legs_at(double seconds) const {
  Legs legs;
  legs.reserve(2 * rays_.world().people.size());
  for (const Person& person : rays_.world().people) {
    for (const Leg& leg : person.legs_at(seconds)) legs.push_back(leg);
  }
  return legs;
}

std::optional<RayHit> LaserModel::cast(const Legs& legs,
                                       const Eigen::Vector3f& origin_m,
                                       const Eigen::Vector3f& direction,
                                       float max_range_m) const {
  std::optional<RayHit> nearest = rays_.cast(origin_m, direction, max_range_m);
  const Eigen::Vector3d origin = origin_m.cast<double>(), way = direction.cast<double>();
  for (const Leg& leg : legs) {
    const auto range_m = range_to_leg(leg, origin, way);
    if (!range_m || *range_m > static_cast<double>(nearest ? nearest->range_m : max_range_m)) {
      continue;
    }
    nearest = RayHit{.range_m = static_cast<float>(*range_m)};
  }
  return nearest;
}

std::optional<float> LaserModel::first_return(const Legs& legs,
                                              Eigen::Vector3f origin_m,
                                              Eigen::Vector3f direction) const {
  constexpr int kMaxPanes = 6;
  float travelled_m = 0.0F;
  for (int pane = 0; pane < kMaxPanes; ++pane) {
    const float left_m = static_cast<float>(options_.range_max_m) - travelled_m;
    const auto hit = left_m > 0.0F ? cast(legs, origin_m, direction, left_m) : std::nullopt;
    if (!hit) return std::nullopt;
    travelled_m += hit->range_m;
    const double incidence_deg = rad_to_deg(
        std::acos(std::clamp(static_cast<double>(-hit->normal.dot(direction)), -1.0, 1.0)));
    const bool reflects =
        hit->material == Material::mirror ||
        (hit->material == Material::glass && incidence_deg > options_.glass_reflects_beyond_deg);
    if (hit->material == Material::plain) return travelled_m;
    if (hit->material == Material::black) {
      if (incidence_deg > options_.black_max_incidence_deg) return std::nullopt;
      return travelled_m;
    }
    if (hit->material == Material::glass && incidence_deg < options_.glass_mirror_incidence_deg) {
      return travelled_m;
    }
    origin_m += hit->range_m * direction;
    if (reflects) direction -= 2.0F * direction.dot(hit->normal) * hit->normal;
    origin_m += 1e-3F * direction;
  }
  return std::nullopt;
}

std::optional<double> LaserModel::beam(const LaserMoment& moment,
                                       double bearing_rad,
                                       std::mt19937_64& random) const {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double half_rad = 0.5 * deg_to_rad(options_.footprint_deg);
  const Eigen::Vector3f origin = moment.world_from_sensor.translation().cast<float>();
  const Eigen::Matrix3d turn = moment.world_from_sensor.linear();
  const Legs legs = legs_at(moment.seconds);
  // Centre and rim of the spot, across and along the sweep.
  const std::array<std::array<double, 2>, 3> rays{{{0, 0}, {-half_rad, 0}, {half_rad, 0}}};
  double nearest = options_.range_max_m + 1.0, farthest = 0.0;
  std::optional<double> centre;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double bearing = bearing_rad + rays[i][0];
    const Eigen::Vector3d ray = turn * Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0);
    const auto range = first_return(legs, origin, ray.cast<float>());
    if (!range) continue;
    if (i == 0) centre = static_cast<double>(*range);
    nearest = std::min(nearest, static_cast<double>(*range));
    farthest = std::max(farthest, static_cast<double>(*range));
  }
  if (!centre) return std::nullopt;
  constexpr double kEdgeM = 0.10;
  const double spread = farthest - nearest;
  if (spread < kEdgeM + 0.05 * *centre) return centre;
  // An edge: near surfaces mix into one echo between them, far ones answer as the nearer or the
  // centre.
  if (spread < options_.mixing_depth_m) return nearest + uniform(random) * spread;
  return uniform(random) < 0.5 ? nearest : *centre;
}

std::vector<float> LaserModel::scan(const std::function<LaserMoment(double)>& moment,
                                    std::mt19937_64& random) const {
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<float> ranges_m(static_cast<std::size_t>(options_.beams));
  for (int i = 0; i < options_.beams; ++i) {
    const double bearing_rad = deg_to_rad(options_.first_bearing_deg + i * options_.step_deg);
    const auto true_range = beam(moment(options_.time_of_beam_s(i)), bearing_rad, random);
    const bool missing = uniform(random) < options_.missing_part;
    double range_m = options_.no_return_m;
    if (true_range && !missing) {
      range_m = std::max(0.0, *true_range + options_.range_sigma_m * noise(random));
      if (options_.quantum_m > 0.0) {
        range_m = std::round(range_m / options_.quantum_m) * options_.quantum_m;
      }
    }
    ranges_m[static_cast<std::size_t>(i)] = static_cast<float>(range_m);
  }
  return ranges_m;
}

}  // namespace marco::sim
