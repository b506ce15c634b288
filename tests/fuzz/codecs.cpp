// Bytes from devices. The first byte of an input says how the rest reaches the codec: raw, or each
// piece wrapped in a telegram whose checksum fits, since no fuzzer guesses those.
#include <algorithm>

#include "drivers/gamepad/codec.hpp"
#include "drivers/hcs12/codec.hpp"
#include "drivers/hokuyo/codec.hpp"
#include "drivers/imu/codec.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/sick/codec.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a folder of codecs

void append(Bytes& stream, std::span<const uint8_t> more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

/// The stream that an input means; `wrap` makes a telegram of a piece.
template <class Wrap>
Bytes stream_of(Input& input, bool wrapped, Wrap wrap) {
  Bytes stream;
  while (!input.empty()) append(stream, wrapped ? wrap(input.piece()) : Bytes());
  return stream;
}

/// Feeds a stream in pieces of `step` bytes and calls `drain` after each.
template <class Push, class Drain>
void feed(std::span<const uint8_t> stream, std::size_t step, Push push, Drain drain) {
  for (std::size_t at = 0; at < stream.size(); at += step) {
    push(stream.subspan(at, std::min(step, stream.size() - at)));
    drain();
  }
}

/// A line without its LF, as the cutter gives it.
std::string without_end(std::string line) {
  line.pop_back();
  return line;
}

struct Way {
  bool wrapped;
  std::size_t step;
};
Way way_of(Input& input) {
  const uint8_t choice = input.byte();
  return {(choice & 1U) != 0, choice < 64 ? 1U + choice / 2U : 4096U};
}

template <class Wrap>
Bytes gather(Input& input, const Way& way, Wrap wrap) {
  if (way.wrapped) return stream_of(input, true, wrap);
  const auto rest = input.rest();
  return {rest.begin(), rest.end()};
}

MARCO_FUZZ(sick) {
  Input input(bytes);
  const Way way = way_of(input);
  const bool from_laser = input.byte() % 2 == 0;
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    return piece.empty() ? Bytes{sick::kAck} : sick::encode_telegram(0x80, piece);
  });
  sick::TelegramParser parser(from_laser ? sick::TelegramParser::Side::laser
                                         : sick::TelegramParser::Side::host);
  const auto drain = [&parser] {
    while (const auto event = parser.next()) {
      if (event->kind != sick::Event::Kind::telegram) continue;
      promise(!event->payload.empty(), "a telegram has a code");
      if (const auto values = sick::decode_values(*event)) {
        promise(values->words.size() <= 1024, "a scan is no longer than its telegram");
        for (const uint16_t word : values->words) sick::special_of(word, sick::range_rule(0));
      }
      sick::decode_configuration(*event);
      sick::decode_status(*event);
      if (event->payload.size() > 1) sick::describe_status_byte(event->status());
    }
  };
  feed(
      stream, way.step, [&](auto part) { parser.push(part); }, drain);
  for (int silence = 0; silence < 10000 && parser.waiting(); ++silence) {
    parser.give_up_waiting();
    drain();
  }
  promise(!parser.waiting(), "after enough silences nothing waits");
}

MARCO_FUZZ(leuze) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Input fields(piece);
    leuze::Telegram telegram;
    telegram.operation = fields.byte() % 2 == 0 ? leuze::kMeasurement : fields.byte();
    telegram.scan_number = fields.byte();
    telegram.step = 1 + fields.byte() % 8;
    telegram.first = 1 + fields.byte();
    for (const uint8_t value : fields.rest()) {
      telegram.values_mm.push_back(static_cast<uint16_t>(value * 256U));
    }
    if (telegram.values_mm.empty()) telegram.values_mm.push_back(0);
    return leuze::encode_telegram(telegram);
  });
  leuze::TelegramParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto telegram = parser.next()) {
          promise(telegram->values_mm.size() <= 1024, "a telegram is no longer than its bytes");
        }
      });
  leuze::decode_body(stream);
  if (const auto ranges = leuze::decode_service_answer(stream)) {
    promise(ranges->size() == leuze::kServiceBeams, "an answer has 133 ranges");
  }
}

MARCO_FUZZ(hokuyo) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    // Lines of printable text, the first the echo.
    hokuyo::Reply reply;
    std::vector<std::string> lines(1);
    for (const uint8_t byte : piece) {
      if (byte == '\n') lines.emplace_back();
      if (byte >= 0x20 && byte < 0x7F) lines.back().push_back(static_cast<char>(byte));
    }
    reply.echo = lines[0];
    reply.status = "99";
    if (lines.size() > 1) reply.lines.assign(lines.begin() + 1, lines.end());
    return hokuyo::encode_reply(reply);
  });
  hokuyo::ReplyParser parser;
  hokuyo::ScanRequest request;
  request.last_step = 100;
  const auto drain = [&] {
    while (const auto reply = parser.next()) {
      reply->command();
      const auto asked = hokuyo::parse_scan_request(reply->echo);
      hokuyo::decode_measurement(*reply, asked.value_or(request));
      hokuyo::decode_parameters(*reply);
    }
  };
  feed(
      stream, way.step, [&](auto part) { parser.push(part); }, drain);
}

MARCO_FUZZ(rplidar) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Input fields(piece);
    const uint8_t what = fields.byte();
    if (what % 3 == 0) {
      return rplidar::encode_descriptor(fields.byte(), fields.byte() % 2 != 0, fields.byte());
    }
    Bytes made;
    rplidar::Capsule capsule;
    capsule.first = fields.byte() % 2 != 0;
    capsule.start_q6 = fields.byte() * 64;
    for (int& distance : capsule.distance_mm) distance = fields.byte() * 16;
    rplidar::Node node;
    node.first = capsule.first;
    node.angle_q6 = capsule.start_q6;
    const auto as_capsule = rplidar::encode_capsule(capsule);
    const auto as_node = rplidar::encode_node(node);
    if (what % 3 == 1) append(made, as_capsule);
    if (what % 3 == 2) append(made, as_node);
    return made;
  });
  rplidar::AnswerParser answers;
  rplidar::RequestParser requests;
  std::optional<rplidar::Capsule> before;
  const auto drain = [&] {
    while (const auto block = answers.next()) {
      if (block->kind != rplidar::kCapsules) continue;
      for (int k = 0; before && k < rplidar::kCapsuleSamples; ++k) {
        const double angle = rplidar::sample_angle_deg(*before, block->capsule, k);
        promise(angle >= 0.0 && angle < 360.0, "a sample's angle lies within a turn");
      }
      before = block->capsule;
    }
    while (requests.next()) {
    }
  };
  feed(
      stream, way.step,
      [&](auto part) {
        answers.push(part);
        requests.push(part);
      },
      drain);
}

MARCO_FUZZ(imu) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Input fields(piece);
    imu::Frame frame;
    frame.kind = fields.byte();
    for (int16_t& value : frame.values) value = static_cast<int16_t>(fields.byte() * 257);
    return imu::encode_frame(frame);
  });
  imu::FrameParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto frame = parser.next()) {
          promise(imu::encode_frame(*frame).size() == imu::kFrameBytes, "a frame has 11 bytes");
        }
        promise(parser.waiting() < imu::kFrameBytes, "no whole frame waits");
      });
}

MARCO_FUZZ(gamepad) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Input fields(piece);
    gamepad::Event event;
    event.time_ms = fields.byte();
    event.kind = fields.byte() % 2 == 0 ? gamepad::Event::Kind::axis : gamepad::Event::Kind::button;
    event.value = static_cast<int16_t>(fields.byte() * 257);
    event.number = fields.byte();
    return gamepad::encode_event(event);
  });
  gamepad::RecordReader reader;
  gamepad::GamepadModel model;
  feed(
      stream, way.step, [&](auto part) { reader.push(part); },
      [&] {
        while (const auto event = reader.next()) model.apply(*event, Utime::from_us(1));
        promise(model.state().axes.size() <= 256 && model.state().buttons.size() <= 256,
                "no more than 256 axes and buttons");
      });
}

MARCO_FUZZ(hcs12) {
  hcs12::LineCutter cutter;
  hcs12::SonarCollector sonar;
  for (const uint8_t byte : bytes) {
    const auto line = cutter.push(byte);
    if (!line) continue;
    promise(line->size() <= hcs12::LineCutter::kMaxLine, "no overlong line");
    if (const auto command = hcs12::parse_command(*line)) {
      promise(command->count <= hcs12::Command::kMaxValues, "no more than 20 numbers");
    }
    if (const auto status = hcs12::parse_wheel_status(*line)) {
      promise(
          hcs12::parse_wheel_status(without_end(hcs12::encode_wheel_status(*status))).has_value(),
          "what was read can be written and read");
    }
    if (const auto millivolts = hcs12::parse_batteries(*line)) {
      promise(hcs12::parse_batteries(without_end(hcs12::encode_batteries(*millivolts))).has_value(),
              "what was read can be written and read");
    }
    hcs12::parse_pantilt_status(*line);
    if (!sonar.collecting()) sonar.begin(16);
    if (const auto times = sonar.push(*line)) {
      promise(times->size() == 16, "all readings or none");
      for (const uint32_t time : *times) hcs12::sonar_range_m(time, 343.0);
    }
  }
}

MARCO_FUZZ(p2os) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    if (piece.empty()) return Bytes{0xFA};
    return p2os::encode_packet(piece.first(std::min(piece.size(), p2os::kMaxPayload)));
  });
  p2os::PacketParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto payload = parser.next()) {
          if (const auto sip = p2os::decode_sip(*payload)) {
            const Bytes packet = p2os::encode_sip(*sip);
            promise(p2os::decode_sip(std::span(packet).subspan(3, packet.size() - 5)) == sip,
                    "a packet of information reads as it was written");
          }
          if (const auto name = p2os::decode_name(*payload)) p2os::model_of(name->subtype);
          p2os::decode_command(*payload);
          if (const auto config = p2os::decode_config(*payload)) p2os::encode_config(*config);
          p2os::decode_encoders(*payload);
          p2os::decode_io(*payload);
        }
      });
}

}  // namespace
}  // namespace marco::fuzz
