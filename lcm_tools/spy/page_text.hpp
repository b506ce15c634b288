#pragma once

#include "lcm_tools/spy/view.hpp"

/// What several pages write.
namespace marco::spy {

std::string plural(int64_t count, const std::string& what);  ///< "1 message", "2 messages"
std::string age_text(double age_s);                          ///< "3.5 s", "12 min"
std::string loss_text(const Loss& loss);                     ///< "12", "~12" when estimated

/// Keeps `selected` among `count` rows on screen. @returns the first of the `shown` rows.
int first_row(int selected, int count, int shown);

enum class Problems : uint8_t { first_three, all };
/// Findings and problems, from row y down, wrapped to the canvas. @returns the row behind.
int draw_findings(Canvas& canvas, const Surroundings& around, int y, Problems problems);

/// How many rows that takes.
int rows_of_findings(const Surroundings& around, int width, Problems problems);

}  // namespace marco::spy
