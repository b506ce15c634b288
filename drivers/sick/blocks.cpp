#include <algorithm>

#include "drivers/sick/codec.hpp"
#include "drivers/transport/little_endian.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::sick {
namespace {

constexpr int kStatusBytes = 152;
constexpr int kOldStatusBytes = 146;

// Codes are counted from the top of the distance: 8191 (no echo) down to 8183 (beyond range).
constexpr std::array<std::pair<int, Special>, 6> kSpecials{{{0, Special::no_echo},
                                                            {1, Special::dazzled},
                                                            {2, Special::overflow},
                                                            {4, Special::noise},
                                                            {5, Special::read_error},
                                                            {8, Special::beyond_range}}};

// Low byte: the UART's divisor of 16 MHz, less one.
constexpr std::array<std::pair<int, int>, 4> kBaudWords{
    {{9600, 0x8067}, {19200, 0x8033}, {38400, 0x8019}, {500000, 0x8001}}};

std::string text_of(std::span<const uint8_t> bytes) {
  std::string text(bytes.begin(), bytes.end());
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

double metres(Unit unit) { return unit == Unit::mm ? 0.001 : unit == Unit::cm ? 0.01 : 0.1; }

RangeRule range_rule(int measuring_mode) {
  switch (measuring_mode) {
    case 0x00:
    case 0x01:
    case 0x02:
      return {0x1FFF, 0x1FF7};
    case 0x03:
    case 0x04:
      return {0x3FFF, 0x3FF7};
    case 0x05:
    case 0x06:
      return {0x7FFF, 0x7FF7};
    case 0x0F:
      return {0xFFFF, 0xFFF7};
    default:
      throw std::invalid_argument("SICK measuring mode " + std::to_string(measuring_mode) +
                                  " carries no distances");
  }
}

std::optional<Special> special_of(uint16_t word, const RangeRule& rule) {
  const uint16_t distance = word & rule.distance_mask;
  if (distance < rule.first_special) return std::nullopt;
  for (const auto& [below_top, special] : kSpecials) {
    if (rule.distance_mask - distance == below_top) return special;
  }
  return Special::unknown;
}

uint16_t word_of(Special special, const RangeRule& rule) {
  for (const auto& [below_top, one] : kSpecials) {
    if (one == special) return static_cast<uint16_t>(rule.distance_mask - below_top);
  }
  return rule.distance_mask;
}

Bytes encode_values(const MeasuredValues& values) {
  require(values.words.size() <= 0x3FF, "a scan has at most 1023 values");
  const bool reflectivity = !values.reflectivity.empty();
  require(!reflectivity || values.sub_range, "reflectivities are of a sub-range");
  const bool range_first = values.sub_range && !reflectivity;
  Bytes payload{values.samples > 0 ? (range_first ? kMeanSubRangeReply : kMeanReply)
                : reflectivity     ? kReflectivityReply
                : range_first      ? kSubRangeReply
                                   : kValuesReply};
  const auto put_range = [&] {
    put_u16(payload, (*values.sub_range)[0]);
    put_u16(payload, (*values.sub_range)[1]);
  };
  if (values.samples > 0) payload.push_back(values.samples);
  if (range_first) put_range();
  int header = static_cast<int>(values.words.size()) | static_cast<int>(values.unit) << 14;
  if (values.partial) header |= 1 << 13 | values.partial_offset_quarters << 11;
  put_u16(payload, static_cast<uint16_t>(header));
  for (const uint16_t word : values.words) put_u16(payload, word);
  if (reflectivity) {
    put_u16(payload, static_cast<uint16_t>(values.reflectivity.size()));
    put_range();
    payload.insert(payload.end(), values.reflectivity.begin(), values.reflectivity.end());
  }
  payload.insert(payload.end(), values.indices.begin(), values.indices.end());
  return payload;
}

std::optional<MeasuredValues> decode_values(const Event& reply) {
  if (reply.payload.size() < 4 || !carries_values(reply.code())) return std::nullopt;
  const uint8_t code = reply.code();
  std::span<const uint8_t> data = reply.data();
  const auto has = [&data](std::size_t count) { return data.size() >= count; };
  MeasuredValues values;
  if (code == kMeanReply || code == kMeanSubRangeReply) {
    values.samples = data[0];
    data = data.subspan(1);
  }
  if (code == kSubRangeReply || code == kMeanSubRangeReply) {
    if (!has(4)) return std::nullopt;
    values.sub_range = {get_u16(data, 0), get_u16(data, 2)};
    data = data.subspan(4);
  }
  if (!has(2)) return std::nullopt;
  const int header = get_u16(data, 0);
  const auto count = static_cast<std::size_t>(header & 0x3FF);
  data = data.subspan(2);
  if (!has(2 * count) || header >> 14 > 2) return std::nullopt;
  values.unit = static_cast<Unit>(header >> 14);
  values.partial = (header >> 13 & 1) != 0;
  values.partial_offset_quarters = header >> 11 & 3;
  values.words.resize(count);
  for (std::size_t i = 0; i < count; ++i) values.words[i] = get_u16(data, 2 * i);
  data = data.subspan(2 * count);
  if (code == kReflectivityReply) {
    if (!has(6) || !has(6u + get_u16(data, 0))) return std::nullopt;
    const std::size_t levels = get_u16(data, 0);
    values.sub_range = {get_u16(data, 2), get_u16(data, 4)};
    values.reflectivity.assign(data.begin() + 6, data.begin() + 6 + static_cast<long>(levels));
    data = data.subspan(6 + levels);
  }
  if (!data.empty() && data.size() != 2) return std::nullopt;
  values.indices.assign(data.begin(), data.end());
  return values;
}

Bytes set_configuration_request(const Configuration& configuration) {
  Bytes payload{kSetConfiguration};
  payload.insert(payload.end(), configuration.bytes.begin(), configuration.bytes.end());
  return encode_request(payload);
}

std::optional<Configuration> decode_configuration(const Event& reply) {
  if (reply.payload.size() < 2 + 7) return std::nullopt;
  const std::span<const uint8_t> data = reply.data();
  return Configuration{Bytes(data.begin(), data.end())};
}

Bytes encode_status(const StatusReport& report) {
  Bytes data(kStatusBytes, 0);
  std::fill_n(data.begin(), 7, uint8_t{' '});
  std::copy_n(report.firmware.begin(), std::min<std::size_t>(7, report.firmware.size()),
              data.begin());
  data[7] = report.mode;
  data[8] = report.defect ? 1 : 0;
  data[17] = report.variant_type;
  const auto put = [&data](std::size_t at, const auto& words) {
    for (std::size_t i = 0; i < words.size(); ++i) set_u16(data, at + 2 * i, words[i]);
  };
  put(18, report.pollution);
  put(34, report.reference_pollution);
  put(42, report.pollution_calibration);
  put(58, report.reference_calibration);
  set_u16(data, 66, report.motor_revolutions);
  data[101] = static_cast<uint8_t>(report.measuring_mode);
  set_u16(data, 106, report.angle_deg);
  set_u16(data, 108, report.resolution_cdeg);
  data[110] = report.restart_mode;
  for (const auto& [baud, word] : kBaudWords) {
    if (baud == report.baud) set_u16(data, 115, word);
  }
  data[117] = report.evaluations;
  data[118] = report.permanent_baud ? 1 : 0;
  data[119] = report.address;
  data[120] = report.field_set;
  data[121] = static_cast<uint8_t>(report.unit);
  data[122] = report.laser_on ? 1 : 0;
  std::fill_n(data.begin() + 123, 7, uint8_t{' '});
  std::copy_n(report.boot_firmware.begin(), std::min<std::size_t>(7, report.boot_firmware.size()),
              data.begin() + 123);
  data.insert(data.begin(), kGetStatus | 0x80);
  return data;
}

std::optional<StatusReport> decode_status(const Event& reply) {
  if (reply.payload.size() < 2 || reply.code() != (kGetStatus | 0x80)) return std::nullopt;
  const std::span<const uint8_t> data = reply.data();
  if (data.size() < kOldStatusBytes) return std::nullopt;
  const std::size_t shift = data.size() < kStatusBytes ? 6 : 0;  // all behind byte 8
  StatusReport report;
  report.firmware = text_of(data.first(7));
  report.mode = data[7];
  report.defect = data[8] != 0;
  report.variant_type = data[17 - shift];
  const auto get = [&data, shift](std::size_t at, auto& words) {
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = get_u16(data, at - shift + 2 * i);
  };
  get(18, report.pollution);
  get(34, report.reference_pollution);
  get(42, report.pollution_calibration);
  get(58, report.reference_calibration);
  report.motor_revolutions = get_u16(data, 66 - shift);
  report.measuring_mode = data[101 - shift];
  report.angle_deg = get_u16(data, 106 - shift);
  report.resolution_cdeg = get_u16(data, 108 - shift);
  report.baud = 0;
  for (const auto& [baud, word] : kBaudWords) {
    if (word == get_u16(data, 115 - shift)) report.baud = baud;
  }
  report.permanent_baud = data[118 - shift] != 0;
  report.address = data[119 - shift];
  report.unit = static_cast<Unit>(data[121 - shift] & 3);
  report.restart_mode = data[110 - shift];
  report.evaluations = data[117 - shift];
  report.field_set = data[120 - shift];
  report.laser_on = data[122 - shift] != 0;
  report.boot_firmware = text_of(data.subspan(123 - shift, 7));
  return report;
}

std::string describe_status_byte(uint8_t status) {
  constexpr std::array<const char*, 8> kSeverity{"",      "info", "warning", "error",
                                                 "fatal", "?",    "?",       "?"};
  std::string text = kSeverity[status & 7];
  const auto add = [&text](bool set, const char* what) {
    if (set) text += (text.empty() ? "" : " ") + std::string(what);
  };
  add((status & 0x20) != 0, "restart");
  add((status & 0x40) != 0, "implausible");
  add((status & 0x80) != 0, "pollution");
  return text;
}

int beams_of_variant(int angle_deg, int resolution_cdeg) {
  const bool exists = (angle_deg == 180 && (resolution_cdeg == 100 || resolution_cdeg == 50)) ||
                      (angle_deg == 100 &&
                       (resolution_cdeg == 100 || resolution_cdeg == 50 || resolution_cdeg == 25));
  return exists ? angle_deg * 100 / resolution_cdeg + 1 : 0;
}

}  // namespace marco::drivers::sick
