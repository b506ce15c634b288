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
        Bytes again = sick::encode_values(*values);
        again.push_back(sick::kHealthy);
        sick::Event written;
        written.payload = again;
        const auto twice = sick::decode_values(written);
        promise(twice && twice->words == values->words, "a scan reads as it was written");
        for (const uint16_t word : values->words) {
          for (const int mode : {0, 3, 5, 15}) sick::special_of(word, sick::range_rule(mode));
        }
      }
      if (const auto configuration = sick::decode_configuration(*event)) {
        sick::set_configuration_request(*configuration);
      }
      if (const auto status = sick::decode_status(*event)) {
        Bytes again = sick::encode_status(*status);
        again.push_back(sick::kHealthy);
        sick::Event written;
        written.payload = again;
        promise(sick::decode_status(written).has_value(), "a status reads as it was written");
        sick::beams_of_variant(status->angle_deg, status->resolution_cdeg);
      }
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
    const uint8_t options = fields.byte();
    telegram.options = Bytes(1U + options % 3U, options);
    telegram.options[0] =
        static_cast<uint8_t>(options & ~3U) | static_cast<uint8_t>(telegram.options.size());
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
  parser.clear();
  leuze::decode_body(stream);
  // As many bytes as an answer has, of whatever there is.
  Bytes answer = stream;
  answer.resize(std::size_t{4} * leuze::kServiceBeams, 0x3F);
  if (const auto ranges = leuze::decode_service_answer(answer)) {
    promise(leuze::encode_service_answer(*ranges) == answer, "an answer reads as it was written");
  }
  leuze::service_request();
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
      const hokuyo::ScanRequest by = asked.value_or(request);
      if (const auto scan = hokuyo::decode_measurement(*reply, by)) {
        const auto again = hokuyo::decode_measurement(hokuyo::encode_measurement(by, 0, *scan), by);
        promise(again && again->values_mm == scan->values_mm, "a scan reads as it was written");
      }
      if (const auto parameters = hokuyo::decode_parameters(*reply)) {
        promise(hokuyo::decode_parameters(hokuyo::encode_parameters(*parameters)).has_value(),
                "parameters read as they were written");
      }
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
    switch (what % 5) {
      case 0:
        return rplidar::encode_descriptor(fields.byte(), fields.byte() % 2 != 0, fields.byte());
      case 1:
        return rplidar::encode_descriptor(rplidar::kNodeSize, true, rplidar::kNodes);
      case 2:
        return rplidar::encode_descriptor(rplidar::kCapsuleSize, true, rplidar::kCapsules);
      default:
        break;
    }
    Bytes made;
    int angle_q6 = fields.byte() * 64;
    while (!fields.empty()) {
      angle_q6 += fields.byte();
      if (what % 5 == 3) {
        rplidar::Node node;
        node.first = fields.byte() % 2 != 0;
        node.angle_q6 = angle_q6 % (360 * 64);
        node.distance_q2 = fields.byte() * 256;
        append(made, rplidar::encode_node(node));
      } else {
        rplidar::Capsule capsule;
        capsule.first = fields.byte() % 2 != 0;
        capsule.start_q6 = angle_q6 % (360 * 64);
        for (int& distance : capsule.distance_mm) distance = fields.byte() * 16;
        append(made, rplidar::encode_capsule(capsule));
      }
    }
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
    event.initial = fields.byte() % 2 != 0;
    event.number = fields.byte();
    return gamepad::encode_event(event);
  });
  gamepad::RecordReader reader;
  gamepad::GamepadModel model;
  feed(
      stream, way.step, [&](auto part) { reader.push(part); },
      [&] {
        while (const auto event = reader.next()) {
          promise(gamepad::encode_event(*event).size() == 8, "a record has eight bytes");
          model.apply(*event, Utime::from_us(1));
        }
        promise(model.state().axes.size() <= 256 && model.state().buttons.size() <= 256,
                "no more than 256 axes and buttons");
      });
  model.disconnect(Utime::from_us(2));
  promise(!model.state().connected, "a gamepad that is away is away");
  const auto& axes = model.state().axes;
  promise(std::all_of(axes.begin(), axes.end(), [](float axis) { return axis == 0.0F; }),
          "and everything rests");
  reader.clear();
}

/// Sonar's readings, written in either form, read.
void sonar_reads(const std::vector<uint32_t>& times) {
  for (const auto form : {hcs12::SonarForm::one_line, hcs12::SonarForm::line_each}) {
    hcs12::SonarCollector collector;
    collector.begin(times.size());
    std::optional<std::vector<uint32_t>> read;
    hcs12::LineCutter lines;
    for (const char c : hcs12::encode_sonar(times, form)) {
      if (const auto line = lines.push(static_cast<uint8_t>(c)); line && !read) {
        read = collector.push(*line);
      }
    }
    promise(read == times, "sonar reads as it was written");
  }
}

/// The firmware's ramp for any order: it ends, or stands where a real wheel's dead zone keeps it.
void ramp_ends(const std::array<uint16_t, hcs12::Command::kMaxValues>& values) {
  const hcs12::Ramp ramp{1U + values[1] % 32U, 1U + values[2] % 64U, values[3] % 16U};
  const auto wheel =
      values[3] % 2 == 0 ? hcs12::RampWalk::Wheel::ideal : hcs12::RampWalk::Wheel::real;
  const auto brake =
      values[0] % 2 == 0 ? hcs12::RampWalk::Brake::to_zero : hcs12::RampWalk::Brake::to_start;
  hcs12::RampWalk walk(ramp, values[0] % 1024U, brake, wheel);
  for (int tick = 0; tick < 2000 && !walk.done(); ++tick) walk.tick();
  promise(walk.clicks() >= 0 && walk.clicks() < 1024 + 256, "it stops within a step of its order");
  promise(walk.ticks() <= 2000 && walk.speed() <= 96, "no wheel is faster than it was told");
}

/// Commands, wheels, batteries and the head: what was read can be written and read.
void hcs12_line(const std::string& line) {
  if (const auto command = hcs12::parse_command(line)) {
    promise(command->count <= hcs12::Command::kMaxValues, "no more than 20 numbers");
    const std::vector<uint32_t> values(command->values.begin(),
                                       command->values.begin() + static_cast<int>(command->count));
    const auto again =
        hcs12::parse_command(without_end(hcs12::encode_command(command->letter, values)));
    promise(again && again->values == command->values, "a command reads as it was written");
    if (command->count >= 3) ramp_ends(command->values);
  }
  if (const auto status = hcs12::parse_wheel_status(line)) {
    const auto again = hcs12::parse_wheel_status(without_end(hcs12::encode_wheel_status(*status)));
    promise(again && again->left_clicks == status->left_clicks, "wheels read as they were written");
  }
  if (const auto millivolts = hcs12::parse_batteries(line)) {
    promise(hcs12::parse_batteries(without_end(hcs12::encode_batteries(*millivolts))) == millivolts,
            "batteries read as they were written");
    const uint32_t adc = hcs12::battery_adc(0, (*millivolts)[0] * 1e-3);
    promise(hcs12::battery_millivolts(0, adc) <= 40000, "what a converter says can be read");
  }
  if (const auto status = hcs12::parse_pantilt_status(line)) {
    const auto again =
        hcs12::parse_pantilt_status(without_end(hcs12::encode_pantilt_status(*status)));
    promise(again && again->pan_clicks == status->pan_clicks && again->full == status->full,
            "a head reads as it was written");
  }
}

MARCO_FUZZ(hcs12) {
  hcs12::LineCutter cutter;
  hcs12::SonarCollector sonar;
  const std::size_t readings = bytes.empty() ? 16 : 1 + bytes.back() % 16;
  for (const uint8_t byte : bytes) {
    const auto line = cutter.push(byte);
    if (!line) continue;
    promise(line->size() <= hcs12::LineCutter::kMaxLine, "no overlong line");
    hcs12_line(*line);
    if (!sonar.collecting()) sonar.begin(readings);
    if (const auto times = sonar.push(*line)) {
      promise(times->size() == readings, "all readings or none");
      for (const uint32_t time : *times) {
        const double range_m = hcs12::sonar_range_m(time, 343.0);
        promise(range_m == 0.0 || hcs12::sonar_time_units(range_m, 343.0) == time,
                "a range is of one time");
      }
      sonar_reads(*times);
    }
  }
  cutter.clear();
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
          if (const auto command = p2os::decode_command(*payload)) {
            promise(!p2os::encode_command(*command).empty(), "a command can be written");
          }
          if (const auto config = p2os::decode_config(*payload)) p2os::encode_config(*config);
          if (const auto encoders = p2os::decode_encoders(*payload)) {
            const Bytes packet = p2os::encode_encoders(*encoders);
            promise(
                p2os::decode_encoders(std::span(packet).subspan(3, packet.size() - 5)) == encoders,
                "encoders read as they were written");
          }
          if (const auto ports = p2os::decode_io(*payload)) {
            const Bytes packet = p2os::encode_io(*ports);
            promise(p2os::decode_io(std::span(packet).subspan(3, packet.size() - 5)) == ports,
                    "ports read as they were written");
          }
        }
      });
}

}  // namespace
}  // namespace marco::fuzz
