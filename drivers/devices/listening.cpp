#include "drivers/devices/listening.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/bno055/codec.hpp"
#include "drivers/cola/codec.hpp"
#include "drivers/create/codec.hpp"
#include "drivers/devices/said_lines.hpp"
#include "drivers/hokuyo/codec.hpp"
#include "drivers/imu/codec.hpp"
#include "drivers/kobuki/codec.hpp"
#include "drivers/ldlidar/codec.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/rplidar/model.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/ydlidar/answer_parser.hpp"

namespace marco::drivers::devices {
namespace {

using Heard = std::span<const uint8_t>;

template <class Parser>
int count_frames(Parser& parser, Heard bytes) {
  parser.push(bytes);
  int frames = 0;
  while (parser.next()) ++frames;
  return frames;
}

std::optional<Claim> ldlidar_says(Heard bytes, Kind /*asked*/) {
  ldlidar::PacketParser parser;
  if (count_frames(parser, bytes) < 2) return std::nullopt;
  return Claim{Kind::ldlidar, "LDROBOT laser"};
}

std::optional<Claim> ydlidar_says(Heard bytes, Kind asked) {
  ydlidar::AnswerParser parser;
  parser.push(bytes);
  int packets = 0;
  std::size_t in_packets = 0;
  while (const auto answer = parser.next()) {
    if (asked == Kind::ydlidar && answer->kind == ydlidar::kInfo &&
        answer->data.size() == ydlidar::kInfoSize) {
      return Claim{Kind::ydlidar,
                   "YDLIDAR " + ydlidar::model_name(ydlidar::decode_info(answer->data).model)};
    }
    if (answer->kind != ydlidar::kPackets) continue;
    ++packets;
    in_packets += answer->size;
  }
  // The exclusive or is weak: packets must be most of what came.
  if (packets < 3 || in_packets * 2 < bytes.size()) return std::nullopt;
  return Claim{Kind::ydlidar, "YDLIDAR"};
}

/// It was left scanning: nodes of five bytes, each with three check bits.
bool is_row_of_nodes(Heard bytes) {
  constexpr int kEnough = 40;
  constexpr int kTurnQ6 = 360 * 64, kMostStepQ6 = 20 * 64;
  for (std::size_t phase = 0; phase < rplidar::kNodeSize; ++phase) {
    int row = 0, before_q6 = 0;
    for (std::size_t at = phase; at + rplidar::kNodeSize <= bytes.size();
         at += rplidar::kNodeSize) {
      const auto node = rplidar::decode_node(bytes.subspan(at).first<rplidar::kNodeSize>());
      const int step_q6 = node ? (node->angle_q6 - before_q6 + 2 * kTurnQ6) % kTurnQ6 : 0;
      const bool follows = step_q6 <= kMostStepQ6 || step_q6 >= kTurnQ6 - 64;
      row = !node ? 0 : row > 0 && !follows ? 1 : row + 1;
      if (row >= kEnough) return true;
      if (node) before_q6 = node->angle_q6;
    }
  }
  return false;
}

bool has_capsules(Heard bytes) {
  for (const uint8_t kind : {rplidar::kCapsules, rplidar::kUltraCapsules}) {
    const std::size_t size = rplidar::capsule_size(kind);
    for (std::size_t at = 0; at + 2 * size <= bytes.size(); ++at) {
      const bool two = rplidar::is_marked_capsule(bytes.subspan(at, size)) &&
                       rplidar::is_marked_capsule(bytes.subspan(at + size, size));
      if (two) return true;
    }
  }
  return false;
}

std::optional<Claim> rplidar_says(Heard bytes, Kind asked) {
  const rplidar::Bytes head = rplidar::encode_descriptor(20, false, rplidar::kInfo);
  const auto found = std::search(bytes.begin(), bytes.end(), head.begin(), head.end());
  const auto behind = static_cast<std::size_t>(bytes.end() - found);
  if (asked == Kind::rplidar && behind >= head.size() + 20) {
    return Claim{Kind::rplidar,
                 rplidar::model_name(found[static_cast<std::ptrdiff_t>(head.size())])};
  }
  if (has_capsules(bytes) || is_row_of_nodes(bytes)) return Claim{Kind::rplidar, "RPLIDAR"};
  return std::nullopt;
}

std::optional<Claim> sick_says(Heard bytes, Kind asked) {
  sick::TelegramParser parser(sick::TelegramParser::Side::laser);
  parser.push(bytes);
  int telegrams = 0;
  while (const auto event = parser.next()) {
    if (event->kind == sick::Event::Kind::telegram) ++telegrams;
  }
  if (telegrams < (asked == Kind::sick ? 1 : 2)) return std::nullopt;
  return Claim{Kind::sick, "SICK LMS"};
}

/// "SOKUIKI Sensor URG-04LX(Hokuyo ...": the maker's word for a range finder says nothing.
std::string product_name(std::string_view behind_key) {
  constexpr std::string_view kSensor = "SOKUIKI Sensor ";
  if (behind_key.starts_with(kSensor)) behind_key.remove_prefix(kSensor.size());
  return "Hokuyo " + std::string(behind_key.substr(0, behind_key.find_first_of("(;\n")));
}

/// Its answer to V has no checksums.
std::optional<Claim> scip1_says(Heard bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t product = text.find("\nPROD:");
  if (text.find("VEND:Hokuyo") == std::string_view::npos || product == std::string_view::npos) {
    return std::nullopt;
  }
  return Claim{Kind::hokuyo, product_name(text.substr(product + 6))};
}

std::optional<Claim> hokuyo_says(Heard bytes, Kind asked) {
  hokuyo::ReplyParser parser;
  parser.push(bytes);
  while (const auto reply = parser.next()) {
    if (reply->lines.empty()) continue;
    for (const std::string& line : reply->lines) {
      if (reply->command() == "VV" && line.starts_with("PROD:")) {
        return Claim{Kind::hokuyo, product_name(line.substr(5))};
      }
    }
    if (reply->status == "99" && hokuyo::parse_scan_request(reply->echo)) {
      return Claim{Kind::hokuyo, "Hokuyo"};
    }
  }
  return asked == Kind::hokuyo ? scip1_says(bytes) : std::nullopt;
}

std::optional<Claim> cola_says(Heard bytes, Kind /*asked*/) {
  cola::TelegramParser parser;
  parser.push(bytes);
  while (const auto telegram = parser.next()) {
    const std::string model = cola::model_of(telegram->text);
    if (telegram->text.starts_with("sRA DeviceIdent ") && !model.empty()) {
      return Claim{Kind::cola, "SICK " + model};
    }
    if (cola::decode_scan(telegram->text)) return Claim{Kind::cola, "SICK TiM or LMS1xx"};
  }
  return std::nullopt;
}

std::optional<Claim> leuze_says(Heard bytes, Kind /*asked*/) {
  leuze::TelegramParser parser;
  if (count_frames(parser, bytes) < 3) return std::nullopt;
  return Claim{Kind::leuze, "Leuze RS4"};
}

std::optional<Claim> imu_says(Heard bytes, Kind /*asked*/) {
  imu::FrameParser parser;
  parser.push(bytes);
  std::size_t frames = 0;
  while (const auto frame = parser.next()) {
    if (frame->kind >= 0x50 && frame->kind <= 0x5A) ++frames;
  }
  if (frames < 4 || frames * imu::kFrameBytes * 4 < bytes.size() * 3) return std::nullopt;
  return Claim{Kind::imu, "WitMotion IMU"};
}

std::optional<Claim> bno055_says(Heard bytes, Kind asked) {
  if (asked != Kind::bno055) return std::nullopt;
  bno055::ReplyParser parser;
  parser.expect(1);
  parser.push(bytes);
  const auto reply = parser.next();
  const bool is_it = reply && reply->data == bno055::Bytes{bno055::kChipId};
  return is_it && bytes.size() == 3 ? std::optional(Claim{Kind::bno055, "Bosch BNO055 IMU"})
                                    : std::nullopt;
}

std::optional<Claim> p2os_says(Heard bytes, Kind asked) {
  p2os::PacketParser parser;
  parser.push(bytes);
  int packets = 0;
  while (const auto payload = parser.next()) {
    const bool is_sync = payload->front() <= 2;
    if (is_sync || p2os::decode_sip(*payload)) ++packets;
  }
  if (packets < (asked == Kind::p2os ? 1 : 2)) return std::nullopt;
  return Claim{Kind::p2os, "Pioneer base (P2OS, ARCOS)"};
}

std::optional<Claim> create_says(Heard bytes, Kind asked) {
  create::FrameParser parser;
  if (count_frames(parser, bytes) < (asked == Kind::create ? 1 : 2)) return std::nullopt;
  return Claim{Kind::create, "iRobot Create 2 or Roomba"};
}

// A YDLIDAR's points begin alike, and have another sum.
std::optional<Claim> kobuki_says(Heard bytes, Kind /*asked*/) {
  kobuki::FrameParser parser;
  parser.push(bytes);
  int frames = 0;
  while (const auto received = parser.next()) {
    frames += kobuki::decode_feedback(received->payload) ? 1 : 0;
  }
  if (frames < 2) return std::nullopt;
  return Claim{Kind::kobuki, "Kobuki (TurtleBot 2)"};
}

constexpr std::array kJudges{kobuki_says, create_says,  ldlidar_says, sick_says,
                             p2os_says,   rplidar_says, hokuyo_says,  bno055_says,
                             cola_says,   imu_says,     leuze_says,   ydlidar_says};

}  // namespace

Claim judge(Heard bytes, Kind asked) {
  if (bytes.empty()) return {};
  for (const auto says : kJudges) {
    if (const auto claim = says(bytes, asked)) return *claim;
  }
  if (const auto claim = judge_lines(bytes, asked)) return *claim;
  return {Kind::bytes, ""};
}

}  // namespace marco::drivers::devices
