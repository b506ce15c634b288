#include "lcm_tools/spy/picture_fields.hpp"

#include <cmath>

namespace marco::spy {

using lcm_schema::Node;
using lcm_schema::NodeKind;
using lcm_schema::Tree;

const Node* field(const Tree& tree, std::string_view name, Match match) {
  if (tree.nodes.empty()) return nullptr;
  for (std::size_t i = 1; i < tree.nodes.size(); i = tree.nodes[i].after) {
    const std::string& own = tree.nodes[i].member->name;
    if (own == name || (match == Match::with_prefix && own.starts_with(name)))
      return &tree.nodes[i];
  }
  return nullptr;
}

const Node* array(const Tree& tree, std::string_view name) {
  const Node* node = field(tree, name);
  return node != nullptr && node->kind == NodeKind::values ? node : nullptr;
}

double number(const Tree& tree, std::string_view name, double otherwise) {
  const Node* node = field(tree, name, Match::with_prefix);
  return node != nullptr && node->kind == NodeKind::value ? tree.number(*node) : otherwise;
}

Size size_of(const Tree& tree) {
  const double width = number(tree, "width", 0);
  const double height = number(tree, "height", 0);
  if (!(width >= 1 && width < 1e5 && height >= 1 && height < 1e5)) return {};
  return {static_cast<int64_t>(width), static_cast<int64_t>(height)};
}

namespace {

// A round length that takes about a fifth of the picture.
double round_length(double whole) {
  const double power = std::pow(10, std::floor(std::log10(whole / 5)));
  const double part = whole / 5 / power;
  return power * (part < 2 ? 1 : part < 5 ? 2 : 5);
}

}  // namespace

void draw_scale(Canvas& canvas, double dots_per_m) {
  const double length_m = round_length(2.0 * canvas.width() / dots_per_m);
  const int cells = static_cast<int>(std::lround(length_m * dots_per_m / 2));
  const int y = canvas.height() - 2;
  for (int x = 1; x <= cells; ++x) canvas.put(x, y, U'─', Style::dim);
  canvas.put(0, y, U'├', Style::dim);
  canvas.put(cells, y, U'┤', Style::dim);
  canvas.text(cells + 2, y, plain_number(length_m) + " m", Style::dim);
}

}  // namespace marco::spy
