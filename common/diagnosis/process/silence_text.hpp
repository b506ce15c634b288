#pragma once

#include <string>
#include <vector>

#include "common/diagnosis/process/bus_survey.hpp"
#include "common/diagnosis/process/silence_judge.hpp"

/// What a person is told of silence. Pure.
namespace marco::diagnosis {

/// One line a lack, then what is on the bus instead and what to do about it; no LF at the end.
/// @param lacks  one at least.
std::string silence_text(const std::vector<Lack>& lacks, const BusSurvey& survey);

/// Equal for situations that need not be told apart: rates and counts are left out.
std::string situation(const std::vector<Lack>& lacks, const BusSurvey& survey);

/// "waiting for scans", "no more messages on LIDAR", for PROCESS_STATUS.
std::string short_state(const Lack& lack);

}  // namespace marco::diagnosis
