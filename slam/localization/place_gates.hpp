#pragma once

#include "common/gate.hpp"
#include "slam/localization/frozen_map.hpp"

namespace marco::slam {

namespace place_gates {

// Part of the points on walls of the map from which on a match says something, as long as it agrees
// with the robot's own path.
inline constexpr double kSomeOverlap = 0.15;

// A scan confirms its place by this part of its beams, when hardly any of the others contradicts.
inline constexpr double kExplained = 0.3;
inline constexpr double kHardly = 0.1;

}  // namespace place_gates

// clang-format off
/// Every rule that decides whether a place in a saved map is believed, and when it is lost.
inline constexpr Gate kPlaceGates[] = {
    {"minimum likelihood", "mean likelihood of a place, less than", PlaceFinderOptions{}.min_score, "no candidate", "assumed"},
    {"explained", "fraction of the points on walls of the map, less than", PlaceFinderOptions{}.sure_explained, "not accepted, unless the next two rows accept it", "localizer.finder.sure_explained"},
    {"explained", "that fraction minus the fraction in free space, less than", PlaceFinderOptions{}.sure_evidence, "the same", "the same, if points contradict"},
    {"explained where known", "fraction of the points on walls, at least", PlaceFinderOptions{}.known_explained, "accepted, with the next row", "if much of the scan is not in the map"},
    {"explained where known", "fraction of the points in free space, at most", PlaceFinderOptions{}.known_contradicted, "accepted, with the row before", "the same"},
    {"contradicted", "fraction of the points in free space, more than", PlaceFinderOptions{}.sure_contradicted, "not accepted", "a similar room has walls where the right one is free"},
    {"rival", "evidence above that of any other place, less than", PlaceFinderOptions{}.sure_margin, "not accepted", "localizer.finder.sure_margin"},
    {"too short a path", "path driven [m], less than", PlaceFinderOptions{}.sure_path_m, "not accepted yet", "localizer.finder.sure_path_m"},
    {"too few keyframes", "keyframes in a row that agree, less than", static_cast<double>(PlaceFinderOptions{}.sure_times), "not accepted yet", "localizer.finder.sure_times"},
    {"too many places", "candidates, at least", static_cast<double>(PlaceFinderOptions{}.max_candidates), "none is accepted: the list may be incomplete", "localizer.finder.max_candidates"},
    {"fine match", "overlap at the place found, less than", LocalizerOptions{}.good_overlap, "the place is rejected", "localizer.good_overlap"},
    {"no match", "overlap while tracking, less than", LocalizerOptions{}.poor_overlap, "the pose is the prediction", "localizer.poor_overlap"},
    {"no match beyond the map", "overlap, less than", place_gates::kSomeOverlap, "the pose follows the robot's own path", "assumed"},
    {"confirmed", "fraction of the beams on walls, at least", place_gates::kExplained, "the place is confirmed, with the next row", "assumed"},
    {"confirmed", "contradicting beams relative to explained ones, at most", place_gates::kHardly, "with the row before", "assumed"},
    {"lost", "fraction of the beams in free space, more than", LocalizerOptions{}.max_contradicted, "the scan contradicts the map", "localizer.max_contradicted"},
    {"lost", "path with contradicting scans [m], at least", LocalizerOptions{}.lost_after_m, "the search starts again", "localizer.lost_after_m"},
    {"lost", "time with contradicting scans [s], at least", LocalizerOptions{}.lost_after_s, "the search starts again", "localizer.lost_after_s"},
};
// clang-format on

}  // namespace marco::slam
