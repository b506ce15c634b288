#pragma once

#include <string>

#include "lcm_tools/spy/view.hpp"

namespace marco::spy {

/// One JSON object without line breaks: source, totals, channels (statistics, type, all candidate
/// types, senders, the last message decoded in full; `byte` arrays as base64), senders with process
/// and losses, listeners, findings, problems.
std::string json_report(const Model& model, const Surroundings& around);

}  // namespace marco::spy
