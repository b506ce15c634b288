#include "slam/localization/session_finder.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

SessionFinder::SessionFinder(FrozenMap& map, const LocalizerOptions& options)
    : map_(&map), options_(options), finder_(map.places(), options.finder) {}

void SessionFinder::restart() {
  finder_.restart();
  estimate_ = {};
  began_m_.reset();
}

std::optional<FoundPlace> SessionFinder::look(const std::vector<Keyframe>& session) {
  // A search costs as much as a hundred scans; in an unknown building all of them fail.
  constexpr double kEagerM = 15.0, kSeldomM = 2.0;
  const double path_m = session.back().path_m;
  if (!began_m_) began_m_ = path_m;
  const bool is_eager = path_m - *began_m_ <= kEagerM || finder_.has_leader();
  if (!is_eager && path_m - looked_m_ < kSeldomM) return std::nullopt;
  looked_m_ = path_m;
  estimate_ = finder_.look(session);
  if (estimate_.status != PlaceEstimate::Status::localized) return std::nullopt;
  const Keyframe& newest = session.back();
  const Pose2 guess = estimate_.candidates.front().map_from_session * newest.world_from_robot;
  const double wanted =
      std::min(options_.good_overlap, 0.8 * estimate_.candidates.front().explained);
  auto place = refined(newest, guess, wanted);
  if (!place) estimate_.status = PlaceEstimate::Status::candidates;
  return place;
}

std::optional<FoundPlace> SessionFinder::look_at(const Keyframe& newest,
                                                 const Pose2& map_from_robot_guess,
                                                 double explained) {
  auto place = refined(newest, map_from_robot_guess, explained);
  if (!place) return std::nullopt;
  const Agreement says = map_->places().agreement(
      beams_of(newest.points_in_robot, newest.sensor_in_robot), place->map_from_robot);
  const bool fits = says.explained >= explained &&
                    says.in_free <= options_.finder.sure_contradicted * says.explained;
  return fits ? place : std::nullopt;
}

std::optional<FoundPlace> SessionFinder::refined(const Keyframe& newest,
                                                 const Pose2& guess,
                                                 double overlap) {
  const SurfelMatch fine = map_->match(newest.points_in_robot, guess, nullptr);
  // The guess is right to some centimetres; a match that goes elsewhere contradicts it.
  constexpr double kAgreesM = 0.3;
  const Pose2 moved = between(guess, fine.map_from_robot);
  if (fine.status == SurfelMatch::Status::no_overlap || fine.overlap < overlap ||
      moved.translation_m().norm() > kAgreesM ||
      std::abs(moved.theta_rad) > deg_to_rad(options_.finder.apart_deg)) {
    return std::nullopt;
  }
  return FoundPlace{fine.map_from_robot, map_->covariance_of(fine.information), fine.overlap,
                    map_->nearest_key(fine.map_from_robot)};
}

}  // namespace marco::slam
