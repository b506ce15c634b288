#include "common/files/points/pcd_header.hpp"

#include <map>
#include <string_view>

#include "common/files/points/scan_pose.hpp"
#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

using Lines = std::map<std::string, std::vector<std::string>, std::less<>>;

// The words after each keyword, until DATA. @returns the header's bytes.
std::size_t read_keywords(const std::string& content, const std::string& name, Lines& lines) {
  constexpr std::size_t kMostWords = 10000;
  std::size_t at = 0;
  while (!lines.contains("DATA")) {
    const std::size_t end = content.find('\n', at);
    require(end != std::string::npos, name + ": not a PCD file: its header has no DATA");
    TextFields words(std::string_view(content).substr(at, end - at));
    at = end + 1;
    const std::string key(words.next());
    if (key.empty() || key.front() == '#') continue;
    std::vector<std::string>& values = lines[key == "COLUMNS" ? "FIELDS" : key];
    for (auto word = words.next(); !word.empty(); word = words.next()) values.emplace_back(word);
    require(values.size() < kMostWords, name + ": not a PCD file: a line of its header has no end");
  }
  return at;
}

class PcdLines {
 public:
  PcdLines(const Lines& lines, const std::string& name) : lines_(&lines), name_(&name) {}

  const std::vector<std::string>& words(std::string_view key) const {
    static const std::vector<std::string> kNone;
    const auto line = lines_->find(key);
    return line == lines_->end() ? kNone : line->second;
  }
  template <class Number>
  Number number(std::string_view key, std::size_t i) const {
    const auto& all = words(key);
    const auto value = i < all.size() ? TextFields(all[i]).number<Number>() : std::nullopt;
    require(value.has_value(), *name_ + ": its " + std::string(key) + " is not a number");
    return *value;
  }

 private:
  const Lines* lines_;
  const std::string* name_;
};

Scalar pcd_scalar(char type, std::size_t size, const std::string& name) {
  struct Known {
    char type;
    std::size_t size;
    Scalar scalar;
  };
  constexpr Known kKnown[] = {{'I', 1, Scalar::int8},    {'U', 1, Scalar::uint8},
                              {'I', 2, Scalar::int16},   {'U', 2, Scalar::uint16},
                              {'I', 4, Scalar::int32},   {'U', 4, Scalar::uint32},
                              {'I', 8, Scalar::int64},   {'U', 8, Scalar::uint64},
                              {'F', 4, Scalar::float32}, {'F', 8, Scalar::float64}};
  for (const Known& known : kKnown) {
    if (known.type == type && known.size == size) return known.scalar;
  }
  throw std::invalid_argument(name + ": no numbers of TYPE " + type + " and SIZE " +
                              std::to_string(size));
}

void read_pcd_fields(const PcdLines& lines, const std::string& name, PcdHeader& header) {
  constexpr std::size_t kMostNumbers = 1 << 20;
  const auto& names = lines.words("FIELDS");
  const auto& types = lines.words("TYPE");
  require(!names.empty() && types.size() == names.size(),
          name + ": expected a TYPE for each of its FIELDS");
  for (std::size_t i = 0; i < names.size(); ++i) {
    PcdField field;
    field.name = names[i];
    field.type = pcd_scalar(types[i].front(), lines.number<std::size_t>("SIZE", i), name);
    if (!lines.words("COUNT").empty()) field.count = lines.number<std::size_t>("COUNT", i);
    require(field.count <= kMostNumbers, name + ": a COUNT of its fields is too large");
    field.column = header.columns;
    field.offset = header.point_bytes;
    header.columns += field.count;
    header.point_bytes += field.bytes();
    header.fields.push_back(std::move(field));
  }
}

void read_pcd_counts(const PcdLines& lines, const std::string& name, PcdHeader& header) {
  const auto width = lines.number<std::size_t>("WIDTH", 0);
  const std::size_t height =
      lines.words("HEIGHT").empty() ? 1 : lines.number<std::size_t>("HEIGHT", 0);
  require(height == 0 || width <= std::numeric_limits<std::size_t>::max() / height,
          name + ": its header declares more points than the file contains");
  header.points = width * height;
  if (!lines.words("POINTS").empty()) {
    require(lines.number<std::size_t>("POINTS", 0) == header.points,
            name + ": its POINTS are not WIDTH times HEIGHT");
  }
  header.rows = height > 1 ? height : 0;
}

void read_viewpoint(const PcdLines& lines, const std::string& name, PcdHeader& header) {
  if (lines.words("VIEWPOINT").empty()) return;
  std::array<double, 7> n{};
  for (std::size_t i = 0; i < n.size(); ++i) n[i] = lines.number<double>("VIEWPOINT", i);
  const bool is_identity = n == std::array<double, 7>{0, 0, 0, 1, 0, 0, 0};
  if (is_identity) return;  // what writers put who know no pose
  header.world_from_scanner = quaternion_pose({n[0], n[1], n[2]}, {n[3], n[4], n[5], n[6]}, name);
}

}  // namespace

PcdHeader read_pcd_header(const std::string& content, const std::string& name) {
  Lines keywords;
  PcdHeader header;
  header.bytes = read_keywords(content, name, keywords);
  const PcdLines lines(keywords, name);
  read_pcd_fields(lines, name, header);
  read_pcd_counts(lines, name, header);
  read_viewpoint(lines, name, header);
  const auto& data = lines.words("DATA");
  const std::string kind = data.empty() ? "" : data.front();
  require(kind == "ascii" || kind == "binary" || kind == "binary_compressed",
          name + ": its DATA is none of ascii, binary, binary_compressed");
  if (kind == "binary") header.data = PcdHeader::Data::binary;
  if (kind == "binary_compressed") header.data = PcdHeader::Data::compressed;
  return header;
}

}  // namespace marco::files
