#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "slam/doctor/doctor.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/picture_order.hpp"

namespace marco {

/// The doctor's word on the map of a job, and what it is about.
struct MapVerdict {
  slam::MapEvidence evidence;
  slam::Diagnosis diagnosis;

  bool is_wrong() const { return diagnosis.verdict == slam::Verdict::wrong; }
};

/// Nothing when localizing: no map is made.
std::optional<MapVerdict> judge_map(const MapJob& job);

/// The fields `verdict` and `doctor` of report.json.
void add_verdict(nlohmann::json& report, const MapVerdict& verdict, const MapJob& job);

/// Says in map.yaml that the map is wrong, for who reads only that. Nothing for other maps.
void mark_map(const std::filesystem::path& folder, const MapVerdict& verdict);

/// Puts the verdict and its places into map.png. Nothing for a good map.
void mark_picture(PictureOrder& map_picture, const MapVerdict& verdict);

/// A picture of each reason that has a place: doctor_1.png, doctor_2.png ...: what the older passes
/// saw, what the newer one saw, and what contradicts.
std::vector<PictureOrder> doctor_pictures(const std::filesystem::path& folder,
                                          const MapVerdict& verdict);

/// Prints the reasons, suggested fixes as lines for --edits, and last `verdict: good`, `verdict:
/// doubtful` or `verdict: wrong`.
/// @param with_pictures  they were drawn, and are named
void print_verdict(const MapVerdict& verdict, const MapJob& job, bool with_pictures);

}  // namespace marco
