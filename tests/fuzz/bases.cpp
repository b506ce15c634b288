// Bytes from bases, gyroscopes and gamepads.
#include <algorithm>

#include "drivers/bno055/codec.hpp"
#include "drivers/create/codec.hpp"
#include "drivers/gamepad/codec.hpp"
#include "drivers/hcs12/codec.hpp"
#include "drivers/hcs12/ramp.hpp"
#include "drivers/imu/codec.hpp"
#include "drivers/kobuki/codec.hpp"
#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/p2os/models.hpp"
#include "drivers/textbase/codec.hpp"
#include "tests/fuzz/telegrams.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a folder of codecs

/// A line without its LF, as the cutter gives it.
std::string without_end(std::string line) {
  line.pop_back();
  return line;
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

MARCO_FUZZ(bno055) {
  Input input(bytes);
  const std::size_t count = input.byte() % 20;
  const auto rest = input.rest();
  bno055::ReplyParser replies;
  bno055::RequestParser requests;
  replies.expect(count);
  feed(
      rest, 7,
      [&](auto part) {
        replies.push(part);
        requests.push(part);
      },
      [&] {
        while (const auto reply = replies.next()) {
          promise(reply->status || reply->data.size() == count, "a reply is as long as asked for");
        }
        while (const auto request = requests.next()) {
          promise(request->count > 0 && request->count <= bno055::kMostBytes, "a request is sane");
          promise(!request->write || request->data.size() == request->count, "it is whole");
        }
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
    LineCutter lines;
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
  LineCutter cutter;
  hcs12::SonarCollector sonar;
  const std::size_t readings = bytes.empty() ? 16 : 1 + bytes.back() % 16;
  for (const uint8_t byte : bytes) {
    const auto line = cutter.push(byte);
    if (!line) continue;
    promise(line->size() <= LineCutter::kMaxLine, "no overlong line");
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

MARCO_FUZZ(create) {
  Input input(bytes);
  const Way way = way_of(input);
  // Frames with a sum that fits, or bytes as they are.
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Bytes frame{0x13, static_cast<uint8_t>(piece.size())};
    frame.insert(frame.end(), piece.begin(), piece.end());
    uint8_t sum = 0;
    for (const uint8_t byte : frame) sum = static_cast<uint8_t>(sum - byte);
    frame.push_back(sum);
    return frame;
  });
  create::FrameParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto received = parser.next()) {
          const auto again = create::decode_frame(create::encode_frame(received->sensors));
          promise(again == received->sensors, "a frame reads as it was written");
        }
      });
  create::RequestParser requests;
  requests.push(stream);
  while (requests.next()) {
  }
}

MARCO_FUZZ(kobuki) {
  Input input(bytes);
  const Way way = way_of(input);
  // Frames with a sum that fits, or bytes as they are.
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Bytes frame{0xAA, 0x55, static_cast<uint8_t>(piece.size())};
    frame.insert(frame.end(), piece.begin(), piece.end());
    uint8_t sum = 0;
    for (const uint8_t byte : std::span(frame).subspan(2)) sum = static_cast<uint8_t>(sum ^ byte);
    frame.push_back(sum);
    return frame;
  });
  kobuki::FrameParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto received = parser.next()) {
          kobuki::decode_order(received->payload);
          const auto told = kobuki::decode_feedback(received->payload);
          if (!told) continue;
          const Bytes again = kobuki::encode_frame(*told);
          promise(kobuki::decode_feedback(std::span(again).subspan(3, again[2])) == told,
                  "feedback reads as it was written");
        }
      });
}

MARCO_FUZZ(textbase) {
  Input input(bytes);
  const Way way = way_of(input);
  // Lines with a sum that fits, or bytes as they are.
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    const std::string line =
        textbase::with_sum({reinterpret_cast<const char*>(piece.data()), piece.size()}) + "\n";
    return Bytes(line.begin(), line.end());
  });
  LineCutter cutter(textbase::kMaxLine);
  for (const uint8_t byte : stream) {
    const auto line = cutter.push(byte);
    if (!line) continue;
    promise(line->size() <= textbase::kMaxLine, "no overlong line");
    const auto body = textbase::without_sum(*line);
    if (!body) continue;
    if (const auto said = textbase::parse_board_line(body->text)) {
      promise(textbase::parse_board_line(textbase::encode(*said)) == said,
              "what a board says reads as it was written");
    }
    if (const auto said = textbase::parse_host_line(body->text)) {
      const std::string written = textbase::with_sum(textbase::encode(*said));
      const auto again = textbase::without_sum(written);
      promise(again && textbase::parse_host_line(again->text) == said,
              "what a host says reads as it was written");
    }
  }
}

}  // namespace
}  // namespace marco::fuzz
