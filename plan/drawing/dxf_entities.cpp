#include "plan/drawing/dxf_entities.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "lcm_tools/base/check.hpp"

namespace marco::plan {
namespace {

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
            "is not a DXF file: line " + std::to_string(line_) + " is not a group code");
    require(line(pair.value), "is truncated: its last group code has no value");
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

// Of the header's $INSUNITS; 0 = not said.
double metres_of_unit(int64_t insunits) {
  constexpr double kInch = 0.0254;  // by definition
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

class DxfParser {
 public:
  explicit DxfParser(const std::string& text) : pairs_(text) {}

  DxfFile read() {
    parse();
    return std::move(file_);
  }

 private:
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
          if (unit_m > 0) file_.unit_m = unit_m;
        }
      } else if (now_) {
        take(pair);
      }
    }
    end_entity();
    require(has_sections_, "is not a DXF file: it has no section");
  }

  static double number_of(const Pair& pair) {
    double value = 0.0;
    const char* first = pair.value.data();
    const char* const last = first + pair.value.size();
    if (first != last && *first == '+') ++first;
    const auto parsed = std::from_chars(first, last, value);
    require(parsed.ec == std::errc{} && parsed.ptr == last && std::isfinite(value) &&
                std::abs(value) <= 1e15,
            "has no number after group code " + std::to_string(pair.code));
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
    DxfEntity& entity = *now_;
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

  std::vector<DxfEntity>& list() { return block_ != nullptr ? block_->entities : file_.entities; }

  void end_entity() {
    if (!now_) return;
    DxfEntity entity = std::move(*now_);
    now_.reset();
    if (is_table_) {
      if ((entity.has_flag(1) || entity.number(62, 7) < 0)) file_.hidden_layers.insert(entity.name);
    } else if (entity.type == "BLOCK") {
      block_ = &file_.blocks[entity.name];
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
      ++file_.left_out[entity.number(67) != 0 ? "on paper space" : "invisible"];
    } else {
      list().push_back(std::move(entity));
    }
  }

  Pairs pairs_;
  DxfFile file_;
  std::optional<DxfEntity> now_;
  DxfFile::Block* block_ = nullptr;
  bool is_table_ = false, has_sections_ = false;
};

}  // namespace

DxfFile parse_dxf(const std::string& text) { return DxfParser(text).read(); }

}  // namespace marco::plan
