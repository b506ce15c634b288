#pragma once

#include <string>
#include <vector>

#include "live/diagnosis/bus_survey.hpp"
#include "live/diagnosis/silence_judge.hpp"

/// Explains missing messages to a person. Pure functions.
namespace marco::diagnosis {

/// One line per lack, then the channels on the bus and the remedy; no LF at the end.
/// @param lacks  at least one.
std::string silence_text(const std::vector<Lack>& lacks, const BusSurvey& survey);

/// A key of the situation: equal where only rates or counts differ.
std::string situation(const std::vector<Lack>& lacks, const BusSurvey& survey);

/// "waiting for scans", "no more messages on LIDAR", for PROCESS_STATUS.
std::string short_state(const Lack& lack);

}  // namespace marco::diagnosis
