#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string_view>

#include "plan/drawing/drawing.hpp"
#include "plan/drawing/svg_path.hpp"
#include "plan/drawing/xml_tags.hpp"

namespace marco::plan {
namespace {

constexpr double kPixelM = 0.0254 / 96;  // CSS: 96 of them are an inch

using Vector = Eigen::Vector2d;

// Metres of a length's unit, as CSS has them; 0: no size on paper.
double metres_of(std::string_view unit) {
  if (unit == "mm") return 0.001;
  if (unit == "cm") return 0.01;
  if (unit == "in") return 0.0254;
  if (unit == "pt") return 0.0254 / 72;
  if (unit == "pc") return 0.0254 / 6;
  return 0.0;
}

struct Length {
  double value = 0.0;
  std::string_view unit;
};

Length length_of(std::string_view text) {
  const std::size_t end = std::min(text.find_first_not_of("0123456789+-. \t\r\n"), text.size());
  const std::size_t e =
      text.substr(end, 1) == "e" && text.size() > end + 1 &&
              std::string_view("0123456789+-").find(text[end + 1]) != std::string_view::npos
          ? std::min(text.find_first_not_of("0123456789+-e.", end), text.size())
          : end;
  const std::size_t after = text.find_last_not_of(" \t\r\n");
  const std::size_t size = after == std::string_view::npos || after + 1 < e ? 0 : after + 1 - e;
  return {SvgNumbers(text.substr(0, e)).number(), text.substr(e, size)};
}

Eigen::Affine2d transform_of(std::string_view text) {
  Eigen::Affine2d all = Eigen::Affine2d::Identity();
  while (true) {
    const std::size_t open = text.find('('), close = text.find(')');
    if (open == std::string_view::npos) return all;
    require(close != std::string_view::npos && close > open, "contains an unterminated transform");
    std::string_view name = text.substr(0, open);
    const std::size_t first = name.find_first_not_of(" \t\r\n,");
    name = first == std::string_view::npos ? std::string_view() : name.substr(first);
    while (!name.empty() && name.back() == ' ') name.remove_suffix(1);
    SvgNumbers numbers(text.substr(open + 1, close - open - 1));
    std::vector<double> given;
    while (!numbers.at_end() && given.size() < 7) given.push_back(numbers.number());
    const auto value = [&](std::size_t i, double otherwise) {
      return i < given.size() ? given[i] : otherwise;
    };
    require(!given.empty(), "contains a transform without numbers");
    Eigen::Affine2d one = Eigen::Affine2d::Identity();
    const double rad = std::remainder(given[0], 360.0) * std::numbers::pi / 180.0;
    if (name == "translate") {
      one.translation() << given[0], value(1, 0);
    } else if (name == "scale") {
      one.linear() << given[0], 0, 0, value(1, given[0]);
    } else if (name == "rotate") {
      const Vector middle(value(1, 0), value(2, 0));
      one.linear() = Eigen::Rotation2Dd(rad).toRotationMatrix();
      one.translation() = middle - one.linear() * middle;
    } else if (name == "skewX") {
      one.linear() << 1, std::tan(rad), 0, 1;
    } else if (name == "skewY") {
      one.linear() << 1, 0, std::tan(rad), 1;
    } else {
      require(name == "matrix" && given.size() == 6, "contains an unknown transform");
      one.matrix() << given[0], given[2], given[4], given[1], given[3], given[5], 0, 0, 1;
    }
    all = all * one;
    text.remove_prefix(close + 1);
  }
}

class SvgReader {
 public:
  explicit SvgReader(const std::string& text) : tags_(text) {}

  Drawing read() {
    XmlTag tag;
    while (tags_.next(tag)) {
      if (tag.closes) {
        // Tags that do not match are some drawing program's fault; what they hold counts.
        if (open_.size() > 1) open_.pop_back();
        continue;
      }
      Open inside = open_.back();
      enter(tag, inside);
      if (tag.is_empty) continue;
      constexpr std::size_t kDeepest = 500;
      require(open_.size() < kDeepest, "is nested more than 500 deep");
      open_.push_back(inside);
    }
    require(has_root_, "is not an SVG file: it has no svg element");
    return std::move(out_.drawing);
  }

 private:
  struct Open {
    Eigen::Affine2d drawing_from_user = Eigen::Affine2d(Eigen::Scaling(1.0, -1.0));
    std::string layer;
    bool is_inkscape_layer = false;
    bool is_hidden = false;
  };

  void enter(const XmlTag& tag, Open& inside) {
    const std::string_view name = tag.local_name();
    if (name == "svg" && !has_root_) return root(tag);
    require(has_root_, "is not an SVG file: it begins with another element");
    const std::string style = tag.attribute("style");
    const auto is_off = [&](const char* property, const char* value) {
      std::string plain;
      for (const char c : style) {
        if (c != ' ') plain += c;
      }
      return tag.attribute(property) == value ||
             plain.find(std::string(property) + ":" + value) != std::string::npos;
    };
    for (const char* unseen :
         {"defs", "symbol", "clipPath", "mask", "marker", "pattern", "style"}) {
      if (name == unseen) inside.is_hidden = true;
    }
    if (is_off("display", "none") || is_off("visibility", "hidden")) inside.is_hidden = true;
    const std::string place = tag.attribute("transform");
    if (!place.empty()) {
      inside.drawing_from_user = inside.drawing_from_user * transform_of(place);
    }
    if (name == "g" || name == "a") return group(tag, inside);
    if (!inside.is_hidden) shape(tag, name, inside);
  }

  void root(const XmlTag& tag) {
    has_root_ = true;
    const std::string view = tag.attribute("viewBox"), width = tag.attribute("width");
    double view_width = 0.0;
    if (!view.empty()) {
      SvgNumbers numbers(view);
      numbers.number();
      numbers.number();
      view_width = numbers.number();
      require(view_width > 0 && numbers.number() > 0, "has an empty viewBox");
    }
    const std::string said = tag.attribute("data-metres-per-unit");
    if (!said.empty()) {
      const double unit_m = SvgNumbers(said).number();
      require(unit_m > 0, "gives a scale that is not above zero");
      out_.drawing.unit_m = unit_m;
    }
    if (width.empty() || width.find('%') != std::string::npos) return;
    const Length size = length_of(width);
    const double unit_m = metres_of(size.unit);
    if (unit_m <= 0 || size.value <= 0) return;
    out_.drawing.paper_unit_m = view_width > 0 ? size.value * unit_m / view_width : kPixelM;
  }

  void group(const XmlTag& tag, Open& inside) const {
    const bool is_layer = tag.attribute("inkscape:groupmode") == "layer";
    if (inside.is_inkscape_layer && !is_layer) return;
    for (const char* by : {"inkscape:label", "id", "class"}) {
      const std::string name = tag.attribute(by);
      if (name.empty()) continue;
      inside.layer = name;
      inside.is_inkscape_layer = is_layer;
      return;
    }
  }

  double length(const XmlTag& tag, const char* name) {
    const std::string text = tag.attribute(name);
    if (text.empty()) return 0.0;
    const Length found = length_of(text);
    if (found.unit.empty() || found.unit == "px") return found.value;
    const double unit_m = metres_of(found.unit);
    require(unit_m > 0, "contains a length in an unknown unit");
    return found.value * unit_m / kPixelM;
  }

  void shape(const XmlTag& tag, std::string_view name, const Open& inside) {
    const Eigen::Affine2d& place = inside.drawing_from_user;
    const std::string own = tag.attribute("class");
    const auto at = [&](const char* x, const char* y) {
      return Vector(length(tag, x), length(tag, y));
    };
    const auto begin = [&] {
      layer_ = out_.layer(own.empty() ? inside.layer : own);
      out_.begin_shape();
    };
    if (name == "line") {
      begin();
      out_.line(place * at("x1", "y1"), place * at("x2", "y2"), layer_);
    } else if (name == "polyline" || name == "polygon") {
      begin();
      chain(tag.attribute("points"), name == "polygon", place);
    } else if (name == "rect") {
      // A background.
      if (tag.attribute("width").find('%') != std::string::npos) return;
      begin();
      const Vector low = at("x", "y"), size = at("width", "height");
      const Vector corners[] = {low, low + Vector(size.x(), 0), low + size,
                                low + Vector(0, size.y())};
      for (int i = 0; i < 4; ++i)
        out_.line(place * corners[i], place * corners[(i + 1) % 4], layer_);
    } else if (name == "circle" || name == "ellipse") {
      begin();
      const Vector radii = name == "circle" ? at("r", "r") : at("rx", "ry");
      ellipse(at("cx", "cy"), radii, place);
    } else if (name == "path") {
      begin();
      for (const SvgChain& part : read_svg_path(tag.attribute("d"))) {
        for (std::size_t i = 1; i < part.points.size(); ++i) {
          out_.line(place * part.points[i - 1], place * part.points[i], layer_, part.curved[i]);
        }
      }
    } else if (name == "use" || name == "text" || name == "image" || name == "svg") {
      out_.leave_out(std::string(name));
    }
  }

  void chain(const std::string& points, bool is_closed, const Eigen::Affine2d& place) {
    SvgNumbers numbers(points);
    std::optional<Vector> first, before;
    while (!numbers.at_end()) {
      const double x = numbers.number();
      const Vector now = place * Vector(x, numbers.number());
      if (before) out_.line(*before, now, layer_);
      if (!first) first = now;
      before = now;
    }
    if (is_closed && first) out_.line(*before, *first, layer_);
  }

  void ellipse(const Vector& centre, const Vector& radii, const Eigen::Affine2d& place) {
    const int chords = chords_of_span(2 * std::numbers::pi);
    const auto at = [&](int i) -> Vector {
      const double angle = 2 * std::numbers::pi * i / chords;
      return place * Vector(centre + radii.cwiseProduct(Vector(std::cos(angle), std::sin(angle))));
    };
    for (int i = 0; i < chords; ++i) out_.line(at(i), at(i + 1), layer_, true);
  }

  XmlTags tags_;
  DrawingBuilder out_;
  std::vector<Open> open_ = {{}};
  bool has_root_ = false;
  int layer_ = 0;
};

}  // namespace

Drawing read_svg(const std::string& text) { return SvgReader(text).read(); }

}  // namespace marco::plan
