#include "drivers/devices/questions.hpp"

#include <string>

#include "drivers/bno055/codec.hpp"
#include "drivers/cola/codec.hpp"
#include "drivers/create/codec.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/textbase/codec.hpp"
#include "drivers/ydlidar/codec.hpp"

namespace marco::drivers::devices {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes line(const std::string& text) { return {text.begin(), text.end()}; }

std::vector<Question> all_questions() {
  std::vector<Question> all;
  const auto ask = [&all](Kind whom, const std::vector<int>& bauds, const Bytes& bytes) {
    for (const int baud : bauds) all.push_back({whom, baud, bytes, {}, false});
  };
  ask(Kind::rplidar, {115'200, 460'800, 1'000'000, 256'000},
      rplidar::encode_request(rplidar::kGetInfo));
  // Behind Slamtec's: an RPLIDAR waits for the rest of what this begins.
  ask(Kind::ydlidar, {128'000, 230'400, 512'000, 115'200},
      ydlidar::encode_request(ydlidar::kGetInfo));
  ask(Kind::bno055, {bno055::kBaud}, bno055::read_request(bno055::Register::chip_id, 1));
  // A line end first: what was sent before it is nobody's command.
  ask(Kind::hokuyo, {115'200, 19'200, 57'600, 38'400}, line("\nVV\n"));
  ask(Kind::hokuyo, {115'200, 19'200, 57'600, 38'400}, line("\nV\n"));  // SCIP 1
  ask(Kind::textbase, {textbase::kBaud},
      line("\n" + textbase::encode(textbase::WhoAreYou{}) + "\n"));
  ask(Kind::p2os, {p2os::kBaud}, p2os::encode_command({p2os::CommandId::pulse, std::nullopt, ""}));
  ask(Kind::sick, {9600, 38'400, 19'200, 500'000}, sick::encode_request(Bytes{sick::kGetStatus}));
  ask(Kind::hcs12_base, {9600}, line("\nl\n"));
  Bytes start = create::encode_request(create::Opcode::start);
  for (const uint8_t byte : create::stream_request()) start.push_back(byte);
  const Bytes pause{static_cast<uint8_t>(create::Opcode::pause_stream), 0};
  for (const int baud : {create::kBaud, 57'600, 19'200}) {
    all.push_back({Kind::create, baud, start, pause, true});
  }
  return all;
}

}  // namespace

const std::vector<Question>& questions() {
  static const std::vector<Question> kAll = all_questions();
  return kAll;
}

const std::vector<Question>& network_questions() {
  static const std::vector<Question> kAll = [] {
    std::vector<Question> all{{Kind::cola, 0, cola::encode_telegram("sRN DeviceIdent")}};
    for (const Question& question : questions()) {
      if (question.bytes == all.back().bytes) continue;
      all.push_back(question);
      all.back().baud = 0;
    }
    return all;
  }();
  return kAll;
}

const std::vector<int>& rates() {
  static const std::vector<int> kRates{115'200, 230'400, 460'800, 1'000'000, 256'000,
                                       921'600, 128'000, 9600,    512'000,   57'600,
                                       38'400,  19'200,  500'000, 4800};
  return kRates;
}

}  // namespace marco::drivers::devices
