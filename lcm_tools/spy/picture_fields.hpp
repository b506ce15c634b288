#pragma once

#include <string_view>

#include "lcm_tools/spy/picture.hpp"

/// What the kinds of pictures share.
namespace marco::spy {

/// The top-level field with this name; with_prefix: the first whose name begins so ("width_cells").
enum class Match : uint8_t { whole, with_prefix };
const lcm_schema::Node* field(const lcm_schema::Tree& tree,
                              std::string_view name,
                              Match match = Match::whole);
/// Only if it is an array of numbers or bytes.
const lcm_schema::Node* array(const lcm_schema::Tree& tree, std::string_view name);
/// Of the first single value whose name begins so.
double number(const lcm_schema::Tree& tree, std::string_view name, double otherwise);

/// A grid's or image's size; 0 x 0 when its fields contradict each other.
struct Size {
  int64_t width = 0;
  int64_t height = 0;
};
Size size_of(const lcm_schema::Tree& tree);

/// A bar of a round length in the row above the last.
void draw_scale(Canvas& canvas, double dots_per_m);

void draw_grid(Canvas& canvas, std::span<const lcm_schema::Tree> messages, double zoom);
void draw_image(Canvas& canvas, const lcm_schema::Tree& tree, double zoom);

}  // namespace marco::spy
