#include <cstdint>
#include <stdexcept>

#include "common/files/point_columns.hpp"
#include "common/files/points/pcd_header.hpp"
#include "common/files/points/point_collector.hpp"
#include "common/files/points/point_formats.hpp"
#include "common/files/points/text_writer.hpp"
#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

// A control byte below 32 says how many literal bytes follow, less one. Otherwise its upper three
// bits are a length less two (7: a byte to be added follows), its lower five and the next byte the
// distance back, less one.
constexpr std::size_t kLiterals = 32, kLongLength = 7;
constexpr std::size_t kMostOfThreeBytes = kLongLength + 255 + 2;

// Unpacks what LZF packed, as PCD's binary_compressed has it.
// @param bytes  of the unpacked data; no memory is taken for more than LZF can pack so small.
// @throws std::invalid_argument beginning with `name` for data that give another number of bytes.
std::string unpack_lzf(std::string_view packed, std::size_t bytes, const std::string& name) {
  const auto check = [&](bool holds) {
    if (!holds) throw std::invalid_argument(name + ": its compressed points are damaged");
  };
  check(bytes / kMostOfThreeBytes <= packed.size() / 3 + 1);
  std::string out;
  out.reserve(bytes);
  std::size_t at = 0;
  const auto next_byte = [&]() -> std::size_t {
    check(at < packed.size());
    return static_cast<uint8_t>(packed[at++]);
  };
  while (at < packed.size()) {
    const std::size_t control = next_byte();
    if (control < kLiterals) {
      const std::size_t count = control + 1;
      check(count <= packed.size() - at && count <= bytes - out.size());
      out.append(packed, at, count);
      at += count;
      continue;
    }
    std::size_t length = control >> 5U;
    if (length == kLongLength) length += next_byte();
    length += 2;
    const std::size_t distance = ((control & 31U) << 8U) + next_byte() + 1;
    check(distance <= out.size() && length <= bytes - out.size());
    // Byte by byte: the copy may reach into itself.
    for (std::size_t i = 0; i < length; ++i) out += out[out.size() - distance];
  }
  check(out.size() == bytes);
  return out;
}

// What of a PCD file's fields is taken.
struct PcdParts {
  std::array<PcdField, 3> xyz;
  std::optional<PcdField> intensity, packed_color;
  std::optional<std::array<PcdField, 3>> rgb;
};

PcdParts pcd_parts_of(const PcdHeader& header, const std::string& name) {
  std::vector<std::string> names;
  for (const PcdField& field : header.fields) names.push_back(field.count == 1 ? field.name : "_");
  const PointColumns columns = find_point_columns(names);
  require(columns.xyz.has_value(), name + ": its FIELDS have no x, y, z");
  const auto fields_at = [&](const std::array<std::size_t, 3>& at) {
    return std::array{header.fields[at[0]], header.fields[at[1]], header.fields[at[2]]};
  };
  PcdParts parts{fields_at(*columns.xyz), std::nullopt, std::nullopt, std::nullopt};
  if (columns.intensity) parts.intensity = header.fields[*columns.intensity];
  if (columns.rgb) parts.rgb = fields_at(*columns.rgb);
  for (const PcdField& field : header.fields) {
    const bool is_packed = (field.name == "rgb" || field.name == "rgba") && field.bytes() == 4;
    if (is_packed) parts.packed_color = field;
  }
  return parts;
}

std::array<uint8_t, 3> unpacked(uint32_t color) {
  return {static_cast<uint8_t>(color >> 16U), static_cast<uint8_t>(color >> 8U),
          static_cast<uint8_t>(color)};
}

void reserve_for(const PcdHeader& header, const PcdParts& parts, PointCollector& points) {
  points.reserve(header.points,
                 {parts.intensity.has_value(), parts.packed_color || parts.rgb.has_value()});
}

// `number(field)` gives a point's number, `bits(field)` its four bytes.
template <class Number, class Bits>
void add_pcd_point(const PcdParts& parts,
                   const Number& number,
                   const Bits& bits,
                   PointCollector& points) {
  const auto& [x, y, z] = parts.xyz;
  points.add({number(x), number(y), number(z)});
  PointCloud& cloud = points.cloud;
  if (parts.intensity) cloud.intensities.push_back(static_cast<float>(number(*parts.intensity)));
  if (parts.packed_color) {
    cloud.colors_rgb.push_back(unpacked(bits(*parts.packed_color)));
  } else if (parts.rgb) {
    const auto byte = [&](const PcdField& field) { return color_byte(number(field), field.type); };
    const auto& [r, g, b] = *parts.rgb;
    cloud.colors_rgb.push_back({byte(r), byte(g), byte(b)});
  }
}

void read_pcd_text(const std::string& content,
                   const std::string& name,
                   const PcdHeader& header,
                   PointCollector& points) {
  require(header.points <= (content.size() - header.bytes + 1) / (2 * header.columns),
          name + ": its header declares more points than the file contains");
  const PcdParts parts = pcd_parts_of(header, name);
  if (header.points == 0) return;
  reserve_for(header, parts, points);
  const std::string place = name + " (lines after DATA)";
  TextRows rows(std::string_view(content).substr(header.bytes), place);
  std::vector<double> numbers(header.columns);
  const auto number = [&](const PcdField& field) { return numbers[field.column]; };
  const auto bits = [&](const PcdField& field) {
    const double value = numbers[field.column];
    if (field.type == Scalar::float32) return std::bit_cast<uint32_t>(static_cast<float>(value));
    const bool is_integer = std::abs(value) <= 4294967295.0;
    return is_integer ? static_cast<uint32_t>(static_cast<int64_t>(value)) : 0U;
  };
  for (std::size_t i = 0; i < header.points; ++i) {
    if (!rows.next()) rows.fail("ends before the last of its points");
    if (rows.numbers(numbers) < numbers.size()) {
      rows.fail("expected " + std::to_string(numbers.size()) + " numbers");
    }
    add_pcd_point(parts, number, bits, points);
  }
}

// Compressed points lie field by field: all of x, then all of y.
void read_pcd_bytes(std::string_view bytes,
                    const std::string& name,
                    const PcdHeader& header,
                    PointCollector& points) {
  require(header.points <= bytes.size() / header.point_bytes,
          name + ": its header declares more points than the file contains");
  const PcdParts parts = pcd_parts_of(header, name);
  reserve_for(header, parts, points);
  const bool by_field = header.data == PcdHeader::Data::compressed;
  std::size_t i = 0;
  const auto place = [&](const PcdField& field) {
    return bytes.data() + (by_field ? header.points * field.offset + i * field.bytes()
                                    : i * header.point_bytes + field.offset);
  };
  const auto number = [&](const PcdField& field) { return load(place(field), field.type); };
  const auto bits = [&](const PcdField& field) {
    return static_cast<uint32_t>(load(place(field), Scalar::uint32));
  };
  for (; i < header.points; ++i) add_pcd_point(parts, number, bits, points);
}

std::string unpack_points(std::string_view body, const PcdHeader& header, const std::string& name) {
  require(body.size() >= 8, name + ": ends before its compressed points");
  const auto packed = static_cast<std::size_t>(load(body.data(), Scalar::uint32));
  const auto unpacked_bytes = static_cast<std::size_t>(load(body.data() + 4, Scalar::uint32));
  require(packed <= body.size() - 8, name + ": ends inside its compressed points");
  require(header.points <= unpacked_bytes / header.point_bytes &&
              unpacked_bytes == header.points * header.point_bytes,
          name + ": its header does not agree with its compressed points");
  return unpack_lzf(body.substr(8, packed), unpacked_bytes, name);
}

std::string repeated(const char* word, std::size_t times) {
  std::string text;
  for (std::size_t i = 0; i < times; ++i) text += word;
  return text;
}

std::string pcd_header_of(const PointCloud& cloud, bool is_far) {
  const bool has_intensity = !cloud.intensities.empty(), has_color = !cloud.colors_rgb.empty();
  const std::size_t fields = 3U + (has_intensity ? 1U : 0U) + (has_color ? 1U : 0U);
  const std::size_t rows = std::max<std::size_t>(1, cloud.rows);
  TextWriter pose;
  const Pose3 world_from_scanner = cloud.world_from_scanner.value_or(Pose3::Identity());
  const Eigen::Quaterniond turned(world_from_scanner.linear());
  for (int i = 0; i < 3; ++i) pose.number(world_from_scanner.translation()[i], ' ');
  for (const double part : {turned.w(), turned.x(), turned.y()}) pose.number(part, ' ');
  pose.number(turned.z(), '\n');
  std::string text = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z";
  if (has_intensity) text += " intensity";
  if (has_color) text += " rgb";
  text += "\nSIZE" + repeated(is_far ? " 8" : " 4", 3) + repeated(" 4", fields - 3);
  text += "\nTYPE" + repeated(" F", fields) + "\nCOUNT" + repeated(" 1", fields);
  text += "\nWIDTH " + std::to_string(cloud.points_m.size() / rows);
  text += "\nHEIGHT " + std::to_string(rows) + "\nVIEWPOINT " + std::string(pose.text());
  text += "POINTS " + std::to_string(cloud.points_m.size()) + "\nDATA binary\n";
  return text;
}

}  // namespace

PointCloud read_pcd(const std::string& content, const std::string& name) {
  const PcdHeader header = read_pcd_header(content, name);
  require(header.point_bytes > 0, name + ": its points have no coordinates");
  const std::string_view body = std::string_view(content).substr(header.bytes);
  const bool is_packed = header.data == PcdHeader::Data::compressed;
  const std::string points_of_packed = is_packed ? unpack_points(body, header, name) : "";
  PointCloud cloud = collect_points([&](PointCollector& points) {
    if (header.data == PcdHeader::Data::text) {
      read_pcd_text(content, name, header, points);
    } else {
      read_pcd_bytes(is_packed ? points_of_packed : body, name, header, points);
    }
  });
  cloud.rows = header.rows;
  cloud.world_from_scanner = header.world_from_scanner;
  return cloud;
}

void write_pcd(OutputFile& file, const PointCloud& cloud) {
  const bool is_far = !cloud.origin_m.isZero(0.0);
  file.write(pcd_header_of(cloud, is_far));
  std::string bytes;
  const auto append = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    const Eigen::Vector3f& point = cloud.points_m[i];
    for (int axis = 0; axis < 3; ++axis) {
      if (is_far) {
        append(static_cast<double>(point[axis]) + cloud.origin_m[axis]);
      } else {
        append(point[axis]);
      }
    }
    if (!cloud.intensities.empty()) append(cloud.intensities[i]);
    if (!cloud.colors_rgb.empty()) {
      const auto& [red, green, blue] = cloud.colors_rgb[i];
      append(uint32_t{red} << 16U | uint32_t{green} << 8U | uint32_t{blue});
    }
    file.write(bytes);
    bytes.clear();
  }
}

}  // namespace marco::files
