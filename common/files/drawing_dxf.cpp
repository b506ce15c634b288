#include <charconv>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <string_view>

#include "common/files/drawing.hpp"
#include "common/pose2.hpp"

namespace marco::files {
namespace {

using Vector = Eigen::Vector2d;

struct Pair {
  int code = 0;
  std::string_view value;
};

/// The pairs of a group code and a value, each on its line.
class Pairs {
 public:
  explicit Pairs(std::string_view text) : rest_(text) {}

  bool next(Pair& pair) {
    std::string_view code;
    if (!line(code)) return false;
    const auto parsed = std::from_chars(code.data(), code.data() + code.size(), pair.code);
    require(parsed.ec == std::errc{} && parsed.ptr == code.data() + code.size(),
            "is no DXF file: line " + std::to_string(line_) + " is no group code");
    require(line(pair.value), "is cut short: its last group code has no value");
    return true;
  }

 private:
  bool line(std::string_view& found) {
    if (rest_.empty()) return false;
    ++line_;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    found = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!found.empty() && is_blank(found.front())) found.remove_prefix(1);
    while (!found.empty() && is_blank(found.back())) found.remove_suffix(1);
    return true;
  }

  std::string_view rest_;
  std::size_t line_ = 0;
};

struct Corner {
  Vector at = {0, 0};
  double bulge = 0.0;  ///< tangent of a quarter of the arc to the next corner
};

struct Entity {
  std::string type, layer = "0", name;
  std::map<int, double> numbers;  ///< the first of each code
  std::vector<Corner> corners;    ///< of a polyline

  double number(int code, double otherwise = 0.0) const {
    const auto found = numbers.find(code);
    return found != numbers.end() ? found->second : otherwise;
  }
  bool has_flag(int flag) const { return (static_cast<int64_t>(number(70)) & flag) != 0; }
  Vector point(int code) const { return {number(code), number(code + 10)}; }
};

struct Block {
  Vector base = {0, 0};
  std::vector<Entity> entities;
};

// Of the header's $INSUNITS; 0 = not said.
double metres_of_unit(int64_t insunits) {
  constexpr double kInch = 0.0254;
  switch (insunits) {
    case 1:
      return kInch;
    case 2:
      return 12 * kInch;
    case 4:
      return 0.001;
    case 5:
      return 0.01;
    case 6:
      return 1.0;
    case 10:
      return 36 * kInch;
    case 14:
      return 0.1;
    default:
      return 0.0;
  }
}

class DxfReader {
 public:
  explicit DxfReader(const std::string& text) : pairs_(text) {}

  Drawing read() {
    parse();
    for (const Entity& entity : entities_) draw(entity, Eigen::Affine2d::Identity(), "0", 0);
    return std::move(out_.drawing);
  }

 private:
  // -- file to entities

  void parse() {
    Pair pair;
    std::string section, variable;
    bool begins = false;
    while (pairs_.next(pair)) {
      if (pair.code == 0) {
        if (pair.value == "EOF") break;
        end_entity();
        begins = pair.value == "SECTION";
        if (pair.value == "ENDSEC") section.clear();
        if (!begins && !section.empty()) begin_entity(section, std::string(pair.value));
      } else if (begins && pair.code == 2) {
        section = pair.value;
        begins = false;
        has_sections_ = true;
      } else if (section == "HEADER") {
        if (pair.code == 9) variable = pair.value;
        if (variable == "$INSUNITS" && pair.code == 70) {
          const double unit_m = metres_of_unit(static_cast<int64_t>(number_of(pair)));
          if (unit_m > 0) out_.drawing.unit_m = unit_m;
        }
      } else if (now_) {
        take(pair);
      }
    }
    end_entity();
    require(has_sections_, "is no DXF file: it has no section");
  }

  static double number_of(const Pair& pair) {
    double value = 0.0;
    const char* first = pair.value.data();
    const char* const last = first + pair.value.size();
    if (first != last && *first == '+') ++first;
    const auto parsed = std::from_chars(first, last, value);
    require(parsed.ec == std::errc{} && parsed.ptr == last && std::isfinite(value) &&
                std::abs(value) <= 1e15,
            "holds no number behind group code " + std::to_string(pair.code));
    return value;
  }

  void begin_entity(const std::string& section, const std::string& type) {
    is_table_ = section == "TABLES";
    const bool is_drawn = section == "ENTITIES" || section == "BLOCKS";
    if (is_table_ ? type != "LAYER" : !is_drawn) return;
    if (type == "SEQEND") return;
    now_.emplace();
    now_->type = type;
  }

  void take(const Pair& pair) {
    Entity& entity = *now_;
    if (pair.code == 8) entity.layer = pair.value;
    if (pair.code == 2) entity.name = pair.value;
    const bool is_number = (pair.code >= 10 && pair.code < 80) || pair.code == 230;
    if (!is_number) return;
    const double value = number_of(pair);
    if (entity.type == "LWPOLYLINE") {
      if (pair.code == 10) entity.corners.push_back({{value, 0}, 0});
      if (pair.code == 20 && !entity.corners.empty()) entity.corners.back().at.y() = value;
      if (pair.code == 42 && !entity.corners.empty()) entity.corners.back().bulge = value;
    }
    entity.numbers.emplace(pair.code, value);
  }

  std::vector<Entity>& list() { return block_ != nullptr ? block_->entities : entities_; }

  void end_entity() {
    if (!now_) return;
    Entity entity = std::move(*now_);
    now_.reset();
    if (is_table_) {
      if ((entity.has_flag(1) || entity.number(62, 7) < 0)) hidden_.insert(entity.name);
    } else if (entity.type == "BLOCK") {
      block_ = &blocks_[entity.name];
      *block_ = {entity.point(10), {}};
    } else if (entity.type == "ENDBLK") {
      block_ = nullptr;
    } else if (entity.type == "VERTEX") {
      // Points that only steer a smooth curve are none of it.
      constexpr int kSteers = 16;
      if (!list().empty() && list().back().type == "POLYLINE" && !entity.has_flag(kSteers)) {
        list().back().corners.push_back({entity.point(10), entity.number(42)});
      }
    } else if (entity.number(67) != 0 || entity.number(60) != 0) {
      out_.leave_out(entity.number(67) != 0 ? "on paper space" : "invisible");
    } else {
      list().push_back(std::move(entity));
    }
  }

  // -- entities to lines

  void draw(const Entity& entity,
            const Eigen::Affine2d& drawing_from_block,
            const std::string& outer_layer,
            int depth) {
    const std::string& layer_name = entity.layer == "0" ? outer_layer : entity.layer;
    if (hidden_.contains(layer_name)) return out_.leave_out("on a hidden layer");
    // Seen from below: what was mirrored in 3D.
    Eigen::Affine2d place = drawing_from_block;
    const bool is_flat_kind = entity.type != "LINE" && entity.type != "ELLIPSE";
    if (is_flat_kind && entity.number(230, 1.0) < 0) place = place * Eigen::Scaling(-1.0, 1.0);
    if (entity.type == "INSERT") return insert(entity, place, layer_name, depth);
    layer_ = out_.layer(layer_name);
    out_.begin_shape();
    if (entity.type == "LINE") {
      out_.line(place * entity.point(10), place * entity.point(11), layer_);
    } else if (entity.type == "LWPOLYLINE" || entity.type == "POLYLINE") {
      constexpr int kMesh = 16 | 64;
      if (entity.type == "POLYLINE" && entity.has_flag(kMesh)) return out_.leave_out("mesh");
      polyline(entity, place);
    } else if (entity.type == "CIRCLE" || entity.type == "ARC") {
      const double from = entity.type == "ARC" ? deg_to_rad(entity.number(50)) : 0.0;
      double to = entity.type == "ARC" ? deg_to_rad(entity.number(51)) : 2 * std::numbers::pi;
      to = from + turn(to - from);
      const double radius = entity.number(40);
      curve(place, entity.point(10), {radius, 0}, {0, radius}, from, to);
    } else if (entity.type == "ELLIPSE") {
      const Vector major = entity.point(11), minor = entity.number(40) * Vector(-major.y(), major.x());
      const double from = entity.number(41), to = entity.number(42, 2 * std::numbers::pi);
      curve(place, entity.point(10), major, minor, from, from + turn(to - from));
    } else {
      out_.leave_out(entity.type.substr(0, 40));
    }
  }

  // In (0, 2 pi].
  static double turn(double span) {
    constexpr double kWhole = 2 * std::numbers::pi;
    require(std::abs(span) < 1e6, "holds an impossible angle");
    span = std::fmod(span, kWhole);
    return span <= 1e-9 ? span + kWhole : span;
  }

  void curve(const Eigen::Affine2d& place,
             const Vector& centre,
             const Vector& a,
             const Vector& b,
             double from,
             double to) {
    const int chords = chords_of_span(to - from);
    const auto at = [&](int i) -> Vector {
      const double angle = from + (to - from) * i / chords;
      return place * Vector(centre + a * std::cos(angle) + b * std::sin(angle));
    };
    for (int i = 0; i < chords; ++i) out_.line(at(i), at(i + 1), layer_, true);
  }

  void polyline(const Entity& entity, const Eigen::Affine2d& place) {
    const std::vector<Corner>& corners = entity.corners;
    const std::size_t count = corners.size();
    for (std::size_t i = 0; i + (entity.has_flag(1) ? 0 : 1) < count; ++i) {
      const Vector a = corners[i].at, b = corners[(i + 1) % count].at;
      const double bulge = corners[i].bulge;
      if (std::abs(bulge) < 1e-9 || a == b) {
        out_.line(place * a, place * b, layer_);
        continue;
      }
      const Vector chord = b - a, left(-chord.y(), chord.x());
      const Vector centre = (a + b) / 2 + left * (1 - bulge * bulge) / (4 * bulge);
      const Vector start = a - centre;
      curve(place, centre, start, {-start.y(), start.x()}, 0.0, 4 * std::atan(bulge));
    }
  }

  void insert(const Entity& entity,
              const Eigen::Affine2d& place,
              const std::string& layer,
              int depth) {
    constexpr int kDeepest = 16;
    constexpr std::size_t kMostInserts = 1'000'000;
    const auto block = blocks_.find(entity.name);
    if (block == blocks_.end()) return out_.leave_out("INSERT of a block that is not there");
    require(depth < kDeepest, "holds blocks within blocks, more than 16 deep");
    const auto copies = [&](int code) {
      const double count = entity.number(code, 1.0);
      require(count >= 0 && count <= 1e5, "inserts a block more than 100000 times");
      return std::max(1, static_cast<int>(count));
    };
    const int columns = copies(70), rows = copies(71);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        drawn_ += 1 + block->second.entities.size();
        require(drawn_ < kMostInserts * 4, "inserts blocks without end");
        const Vector step(column * entity.number(44), row * entity.number(45));
        Eigen::Affine2d inside = place * Eigen::Translation2d(entity.point(10)) *
                                 Eigen::Rotation2Dd(deg_to_rad(entity.number(50)));
        inside = inside * Eigen::Translation2d(step) *
                 Eigen::Scaling(entity.number(41, 1.0), entity.number(42, 1.0)) *
                 Eigen::Translation2d(-block->second.base);
        for (const Entity& part : block->second.entities) draw(part, inside, layer, depth + 1);
      }
    }
  }

  Pairs pairs_;
  DrawingBuilder out_;
  std::vector<Entity> entities_;
  std::map<std::string, Block> blocks_;
  std::set<std::string> hidden_;
  std::optional<Entity> now_;
  Block* block_ = nullptr;
  bool is_table_ = false, has_sections_ = false;
  int layer_ = 0;
  std::size_t drawn_ = 0;
};

}  // namespace

Drawing read_dxf(const std::string& text) { return DxfReader(text).read(); }

}  // namespace marco::files
