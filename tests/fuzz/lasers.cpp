// Bytes from lasers.
#include "drivers/cola/codec.hpp"
#include "drivers/hokuyo/codec.hpp"
#include "drivers/ldlidar/codec.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/rplidar/ultra_capsule.hpp"
#include "drivers/rplidar/ultra_dense_capsule.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/ydlidar/answer_parser.hpp"
#include "tests/fuzz/telegrams.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a folder of codecs

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
  answer.resize(leuze::kServiceBytes, 0x3F);
  if (const auto ranges = leuze::decode_service_answer(answer)) {
    promise(leuze::encode_service_answer(*ranges) == answer, "an answer reads as it was written");
  }
  leuze::service_request();
}

MARCO_FUZZ(cola) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Input fields(piece);
    const uint8_t what = fields.byte();
    if (what % 4 == 0) {
      const auto rest = fields.rest();
      return cola::encode_telegram(std::string(rest.begin(), rest.end()));
    }
    cola::ScanData scan;
    scan.status = fields.byte() % 8;
    scan.rate_chz = fields.byte() * 100;
    scan.begin_us = fields.byte() << 24;
    scan.encoders.resize(fields.byte() % 4);
    auto& channels = what % 4 == 1 ? scan.narrow : scan.wide;
    channels.resize(1 + fields.byte() % 3);
    for (cola::Channel& channel : channels) {
      channel.name = fields.byte() % 2 == 0 ? "DIST1" : "RSSI1";
      channel.scale = fields.byte() / 16.0;
      channel.step_e4 = fields.byte() * 64 - 4096;
      for (int left = fields.byte(); left > 0; --left) channel.values.push_back(fields.byte());
    }
    std::string text = cola::encode_scan(scan, "sSN");
    // Cut, or with one other character.
    if (what % 8 == 2) text.resize(fields.byte() % text.size());
    if (what % 8 == 6) text[fields.byte() % text.size()] = static_cast<char>(fields.byte());
    return cola::encode_telegram(text);
  });
  cola::TelegramParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto telegram = parser.next()) {
          promise(telegram->text.size() <= cola::kMostText + 4096, "a telegram has an end");
          cola::refusal(telegram->text);
          cola::range_max_of(cola::model_of(telegram->text));
          const auto scan = cola::decode_scan(telegram->text);
          if (!scan) continue;
          const auto again = cola::decode_scan(cola::encode_scan(*scan, "sRA"));
          promise(again == scan, "a scan reads as it was written");
        }
      });
  parser.clear();
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
    if (what % 16 == 10) {
      return rplidar::encode_descriptor(rplidar::kUltraDenseCapsuleSize, true,
                                        rplidar::kUltraDenseCapsules);
    }
    switch (what % 8) {
      case 0:
        return rplidar::encode_descriptor(fields.byte(), fields.byte() % 2 != 0, fields.byte());
      case 1:
        return rplidar::encode_descriptor(rplidar::kNodeSize, true, rplidar::kNodes);
      case 2:
        return rplidar::encode_descriptor(rplidar::kCapsuleSize, true, rplidar::kCapsules);
      case 3:
        return rplidar::encode_descriptor(rplidar::kCapsuleSize, true, rplidar::kDenseCapsules);
      case 6:
        return rplidar::encode_descriptor(rplidar::kUltraCapsuleSize, true,
                                          rplidar::kUltraCapsules);
      default:
        break;
    }
    Bytes made;
    int angle_q6 = fields.byte() * 64;
    while (!fields.empty()) {
      angle_q6 += fields.byte();
      if (fields.byte() % 2 == 0) {
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
        for (uint32_t& cabin : capsule.cabins) cabin = fields.byte() * 0x01010101U;
        if (what % 8 == 7) append(made, rplidar::encode_ultra_capsule(capsule));
        if (what % 16 == 4) append(made, rplidar::encode_capsule(capsule));
        if (what % 16 == 12) append(made, rplidar::encode_ultra_dense_capsule(capsule));
        if (what % 8 == 5) append(made, rplidar::encode_dense_capsule(capsule));
      }
    }
    return made;
  });
  rplidar::AnswerParser answers;
  rplidar::RequestParser requests;
  std::optional<rplidar::Capsule> before;
  const auto drain = [&] {
    while (const auto block = answers.next()) {
      if (!rplidar::are_capsules(block->kind)) continue;
      if (before) {
        for (const auto& sample : rplidar::samples_of(*before, block->capsule)) {
          promise(sample.angle_deg >= 0.0 && sample.angle_deg < 360.0,
                  "a sample's angle lies within a turn");
          promise(sample.range_mm >= 0, "no range is negative");
        }
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

MARCO_FUZZ(ldlidar) {
  Input input(bytes);
  const Way way = way_of(input);
  const Bytes stream = gather(input, way, [](std::span<const uint8_t> piece) {
    Input fields(piece);
    ldlidar::Packet packet;
    packet.speed_deg_per_s = fields.byte() * 256;
    packet.start_cdeg = fields.byte() * 145;
    packet.end_cdeg = fields.byte() * 145;
    packet.stamp_ms = fields.byte() * 256;
    for (ldlidar::Sample& sample : packet.samples) sample = {fields.byte() * 256, fields.byte()};
    Bytes made;
    append(made, ldlidar::encode_packet(packet));
    return made;
  });
  ldlidar::PacketParser parser;
  feed(
      stream, way.step, [&](auto part) { parser.push(part); },
      [&parser] {
        while (const auto received = parser.next()) {
          const auto packet = ldlidar::decode_packet(ldlidar::encode_packet(received->packet));
          promise(packet == received->packet, "a packet reads as it was written");
          for (int i = 0; i < ldlidar::kPacketSamples; ++i) {
            const double angle = ldlidar::sample_angle_deg(*packet, i);
            promise(angle >= 0.0 && angle < 360.0, "a sample's angle lies within a turn");
          }
        }
      });
}

MARCO_FUZZ(ydlidar) {
  Input input(bytes);
  const Way way = way_of(input);
  const auto form = static_cast<ydlidar::SampleForm>(input.byte() % 3);
  const Bytes stream = gather(input, way, [form](std::span<const uint8_t> piece) {
    Input fields(piece);
    const uint8_t what = fields.byte();
    if (what % 8 == 0) {
      return ydlidar::encode_header(fields.byte(), fields.byte() % 2 != 0, fields.byte());
    }
    ydlidar::Packet packet;
    packet.turn_start = what % 8 == 1;
    packet.frequency_dhz = fields.byte() / 2;
    packet.first_q6 = fields.byte() * 90;
    packet.last_q6 = fields.byte() * 90;
    do {
      packet.samples.push_back({fields.byte() * 64.0, fields.byte()});
    } while (!fields.empty() && packet.samples.size() < ydlidar::kMaxSamples);
    return ydlidar::encode_packet(packet, form);
  });
  ydlidar::AnswerParser parser;
  const auto drain = [&parser] {
    while (const auto answer = parser.next()) {
      if (answer->kind != ydlidar::kPackets) {
        promise(!answer->data.empty() && answer->data.size() <= ydlidar::kInfoSize,
                "a reply has its kind's length");
        if (answer->data.size() == ydlidar::kInfoSize) {
          promise(!ydlidar::model_name(ydlidar::decode_info(answer->data).model).empty(),
                  "every model has a name");
        }
        continue;
      }
      const ydlidar::Packet& packet = answer->packet;
      const Bytes again = ydlidar::encode_packet(packet, answer->form);
      const auto twice = ydlidar::decode_packet(again, answer->form);
      promise(twice && twice->samples == packet.samples, "a packet reads as it was written");
      for (std::size_t i = 0; i < packet.samples.size(); ++i) {
        const double angle = ydlidar::sample_angle_deg(packet, i);
        promise(angle >= 0.0 && angle < 360.0, "a sample's angle lies within a turn");
        const double correction = ydlidar::angle_correction_deg(packet.samples[i].range_mm);
        promise(correction > -90.0 && correction < 90.0, "no laser looks behind its light");
      }
    }
  };
  feed(
      stream, way.step, [&](auto part) { parser.push(part); }, drain);
  parser.clear();
}

}  // namespace
}  // namespace marco::fuzz
