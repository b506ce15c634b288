#include "plan/known_plan/known_plan.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "lcm_tools/base/format.hpp"

namespace marco::plan {
namespace {

constexpr std::string_view kWalls[] = {"wall",        "wand",  "w\xC3\xA4nd",   "waend",   "mauer",
                                       "mur",         "muro",  "parete",        "pared",   "vegg",
                                       "v\xC3\xA4gg", "col",   "st\xC3\xBCtze", "stuetze", "pillar",
                                       "post",        "pilast"};
constexpr std::string_view kOthers[] = {"unseen",
                                        "door",
                                        "t\xC3\xBCr",
                                        "tuer",
                                        "porte",
                                        "puerta",
                                        "dim",
                                        "bema",
                                        "ma\xC3\x9F",
                                        "text",
                                        "anno",
                                        "note",
                                        "furn",
                                        "m\xC3\xB6"
                                        "bel",
                                        "moebel",
                                        "equip",
                                        "hatch",
                                        "schraff",
                                        "patt",
                                        "grid",
                                        "axis",
                                        "achse",
                                        "room",
                                        "raum",
                                        "defpoints",
                                        "title",
                                        "border",
                                        "rahmen",
                                        "elec",
                                        "light",
                                        "plumb",
                                        "stair",
                                        "treppe",
                                        "path",
                                        "site",
                                        "area",
                                        "ceil",
                                        "roof",
                                        "dach",
                                        "symbol",
                                        "legend"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c);
  });
  return text;
}

template <class Words>
bool says_one_of(const std::string& name, const Words& words) {
  const std::string plain = lower(name);
  return std::any_of(std::begin(words), std::end(words),
                     [&](std::string_view word) { return plain.find(word) != std::string::npos; });
}

std::optional<double> number_of(std::string_view text) {
  double value = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = parsed.ec == std::errc{} && parsed.ptr == text.data() + text.size();
  return is_whole && value > 0 && value < 1e6 ? std::optional(value) : std::nullopt;
}

double unit_of(const Drawing& drawing, const std::string& wish, double extent) {
  constexpr double kInch = 0.0254;  // by definition
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"mm", 0.001}, {"cm", 0.01}, {"m", 1.0}, {"in", kInch}, {"ft", 12 * kInch}};
  if (wish.empty()) {
    require(drawing.unit_m.has_value(),
            "does not give its scale: pass --unit mm, cm, m, in, ft or, if it is drawn to scale on "
            "paper, 1:100" +
                format(". Its size would be %.3g m in mm, %.3g m in cm, %.4g m in m",
                       extent * 0.001, extent * 0.01, extent));
    return *drawing.unit_m;
  }
  for (const auto& [name, unit_m] : kUnits) {
    if (wish == name) return unit_m;
  }
  if (wish.starts_with("1:")) {
    const auto scale = number_of(std::string_view(wish).substr(2));
    require(scale.has_value(), "--unit " + wish + ": is not a scale");
    require(drawing.paper_unit_m.has_value(),
            "has no paper size, which a scale needs: pass --unit in metres");
    return *drawing.paper_unit_m * *scale;
  }
  const auto metres = number_of(wish);
  require(metres.has_value(), "--unit " + wish + ": is not mm, cm, m, in, ft, 1:N or a number");
  return *metres;
}

}  // namespace

Eigen::Vector2d KnownPlan::low_m() const {
  Eigen::Vector2d low = lines.front().from;
  for (const Line& line : lines) low = low.cwiseMin(line.from).cwiseMin(line.to);
  return low;
}

Eigen::Vector2d KnownPlan::high_m() const {
  Eigen::Vector2d high = lines.front().from;
  for (const Line& line : lines) high = high.cwiseMax(line.from).cwiseMax(line.to);
  return high;
}

std::vector<bool> choose_layers(const std::vector<std::string>& layers, const std::string& wanted) {
  std::vector<bool> taken(layers.size(), false);
  if (!wanted.empty()) {
    for (std::size_t begin = 0; begin <= wanted.size();) {
      const std::size_t end = std::min(wanted.find(',', begin), wanted.size());
      const std::string name = wanted.substr(begin, end - begin);
      const auto found = std::find(layers.begin(), layers.end(), name);
      std::string all;
      for (const std::string& layer : layers) all += (all.empty() ? "" : ", ") + layer;
      require(found != layers.end(), "has no layer \"" + name + "\" with lines; it has " + all);
      taken[static_cast<std::size_t>(found - layers.begin())] = true;
      begin = end + 1;
    }
    return taken;
  }
  for (std::size_t i = 0; i < layers.size(); ++i) {
    taken[i] = says_one_of(layers[i], kWalls) && !says_one_of(layers[i], kOthers);
  }
  if (std::find(taken.begin(), taken.end(), true) != taken.end()) return taken;
  for (std::size_t i = 0; i < layers.size(); ++i) taken[i] = !says_one_of(layers[i], kOthers);
  return taken;
}

KnownPlan known_plan_of(const Drawing& drawing, const PlanWish& wish) {
  std::vector<bool> has_lines(drawing.layers.size(), false);
  for (const DrawnLine& line : drawing.lines) {
    has_lines[static_cast<std::size_t>(line.layer)] = true;
  }
  // A name without lines must not keep the others away.
  std::vector<std::string> drawn;
  std::vector<std::size_t> index(drawing.layers.size(), 0);
  for (std::size_t i = 0; i < drawing.layers.size(); ++i) {
    if (!has_lines[i]) continue;
    index[i] = drawn.size();
    drawn.push_back(drawing.layers[i]);
  }
  require(!drawn.empty(), "holds no line, circle or arc");
  const std::vector<bool> taken = choose_layers(drawn, wish.layers);
  KnownPlan plan;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    (taken[i] ? plan.taken : plan.passed_over).push_back(drawn[i]);
  }
  for (const DrawnLine& line : drawing.lines) {
    if (!taken[index[static_cast<std::size_t>(line.layer)]]) continue;
    plan.lines.push_back({line.from, line.to, line.shape, line.curved});
  }
  require(!plan.lines.empty(), "has no layer with a name for walls: pass --layers");
  const double extent = (plan.high_m() - plan.low_m()).maxCoeff();
  plan.unit_m = unit_of(drawing, wish.unit, extent);
  const double extent_m = extent * plan.unit_m;
  require(
      extent_m >= 1.0 && extent_m <= 1000.0,
      format("is %.4g m large with a unit of %g m: pass the right --unit", extent_m, plan.unit_m));
  double length_m = 0.0;
  for (KnownPlan::Line& line : plan.lines) {
    line.from *= plan.unit_m;
    line.to *= plan.unit_m;
    length_m += line.length_m();
  }
  require(length_m <= 300e3, "holds more than 300 km of walls");
  return plan;
}

}  // namespace marco::plan
