#include "tools/map/beam_search.hpp"

#include <algorithm>

#include "lcmtypes/channels.hpp"
#include "slam/calibration/floor_search.hpp"

namespace marco {
namespace {

// The laser that the map is made by: the only one.
std::optional<std::string> channel_of(const MapJob& job) {
  std::optional<std::string> only;
  for (const auto& [channel, info] : job.recorded().sensors) {
    if (!channel.starts_with(channels::kLidar)) continue;
    if (only) return std::nullopt;
    only = channel;
  }
  return only;
}

}  // namespace

bool BeamSearch::is_off() const {
  return found.bearing_scale.differs_from(1.0) || found.range_offset_m.differs_from(0.0);
}

BeamCalibration BeamSearch::corrected() const {
  BeamCalibration result = in_use;
  if (found.bearing_scale.differs_from(1.0)) result.bearing_scale *= found.bearing_scale.value;
  if (found.range_offset_m.differs_from(0.0)) result.range_offset_m += found.range_offset_m.value;
  return result;
}

void BeamSearch::add_to(slam::SelfCalibration& calibration, bool better) const {
  using slam::ParameterVerdict;
  const auto verdict_of = [better](bool off) {
    if (!off) return ParameterVerdict::as_assumed;
    return better ? ParameterVerdict::applied : ParameterVerdict::no_better;
  };
  calibration.parameters.push_back({"beams.bearing_scale", in_use.bearing_scale,
                                    in_use.bearing_scale * found.bearing_scale.value,
                                    in_use.bearing_scale * found.bearing_scale.sigma,
                                    verdict_of(found.bearing_scale.differs_from(1.0)), ""});
  calibration.parameters.push_back({"beams.range_offset_m", in_use.range_offset_m,
                                    in_use.range_offset_m + found.range_offset_m.value,
                                    found.range_offset_m.sigma,
                                    verdict_of(found.range_offset_m.differs_from(0.0)), ""});
}

std::optional<BeamSearch> search_beams(const MapJob& job) {
  const auto channel = channel_of(job);
  if (!channel) return std::nullopt;
  BeamCalibration in_use{*channel};
  for (const BeamCalibration& beams : job.calibration().beams) {
    if (beams.channel == *channel) in_use = beams;
  }
  const auto found = slam::fit_beams(
      job.mapper().keys(), in_use.bearing_scale * job.recorded().least_bearing_rad(*channel));
  if (!found) return std::nullopt;
  return BeamSearch{in_use, *found};
}

std::optional<FloorLine> search_floor(const MapJob& job) {
  const auto channel = channel_of(job);
  if (!channel || job.recorded().sensors.at(*channel).mount != SensorInfo::Mount::robot)
    return std::nullopt;
  auto found = slam::find_floor(job.mapper().keys());
  if (found) found->channel = *channel;
  return found;
}

}  // namespace marco
