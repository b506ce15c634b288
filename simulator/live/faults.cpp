#include "simulator/live/faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

constexpr Duration kLate = Duration::from_us(500'000);
constexpr int64_t kPeriodUs = 1'000'000, kSilentUs = 400'000;
constexpr unsigned kGarbagePercent = 30;
constexpr double kLongest_s = 1e6;  // longer makes no sense, and times must not overflow

struct Named {
  const char* name;
  FaultKind kind;
  const char* meaning;
};
constexpr std::array<Named, 7> kKinds{{
    {"off", FaultKind::off, "its cable is cut: it neither hears nor speaks"},
    {"stuck", FaultKind::stuck,
     "tells the same again and again; wheels and pan-tilt count but do not move"},
    {"garbage", FaultKind::garbage, "three of ten bytes that it sends are others"},
    {"slow", FaultKind::slow, "what it sends comes 0.5 s late"},
    {"wrong", FaultKind::wrong,
     "a constant offset: laser 0.2 m, IMU 3 deg/s, left wheel 10 %, tilt 2 deg"},
    {"intermittent", FaultKind::intermittent, "off for 0.4 s of each second"},
    {"unplugged", FaultKind::unplugged, "its port is gone"},
}};

const char* name_of(FaultKind kind) {
  return std::find_if(kKinds.begin(), kKinds.end(),
                      [kind](const Named& named) { return named.kind == kind; })
      ->name;
}

}  // namespace

FaultKind fault_kind_named(const std::string& name) {
  std::string known;
  for (const Named& named : kKinds) {
    if (name == named.name) return named.kind;
    known += std::string(known.empty() ? "" : ", ") + named.name;
  }
  throw std::invalid_argument("fault '" + name + "': expected one of " + known);
}

std::string describe_faults() {
  std::string text;
  for (const Named& named : kKinds) {
    std::string line = named.name;
    line.resize(14, ' ');
    text += line + named.meaning + "\n";
  }
  return text;
}

void FaultBoard::add(const FaultSpec& spec, Utime now) {
  std::string known;
  for (const std::string& device : devices_) known += (known.empty() ? "" : ", ") + device;
  require(std::find(devices_.begin(), devices_.end(), spec.device) != devices_.end(),
          "fault of '" + spec.device + "': this robot has " + known);
  const auto over = [now](const Fault& fault) { return fault.until <= now; };
  faults_.erase(std::remove_if(faults_.begin(), faults_.end(), over), faults_.end());
  if (spec.kind == "none") {
    const auto its = [&spec](const Fault& fault) { return fault.device == spec.device; };
    faults_.erase(std::remove_if(faults_.begin(), faults_.end(), its), faults_.end());
    return;
  }
  // Written so that NaN fails too.
  require(spec.start_s >= 0.0 && spec.start_s <= kLongest_s && spec.duration_s > 0.0 &&
              spec.duration_s <= kLongest_s,
          "fault of '" + spec.device + "': start_s from 0 and duration_s above 0, to 1e6 s");
  constexpr std::size_t kMost = 1000;
  require(faults_.size() < kMost, "there are 1000 faults already");
  const Utime from = now + Duration::from_seconds(spec.start_s);
  faults_.push_back({spec.device, fault_kind_named(spec.kind), from,
                     from + Duration::from_seconds(spec.duration_s)});
}

bool FaultBoard::has(const std::string& device, FaultKind kind, Utime now) const {
  return std::any_of(faults_.begin(), faults_.end(), [&](const Fault& fault) {
    return fault.kind == kind && fault.from <= now && now < fault.until && fault.device == device;
  });
}

std::string FaultBoard::state(Utime now) const {
  std::string text;
  for (const Fault& fault : faults_) {
    if (now < fault.from || fault.until <= now) continue;
    text += (text.empty() ? "" : ", ") + fault.device + " " + name_of(fault.kind);
  }
  return text;
}

bool FaultyEmulator::silent(Utime now) const {
  if (board_.has(device_, FaultKind::off, now)) return true;
  return board_.has(device_, FaultKind::intermittent, now) && now.us % kPeriodUs < kSilentUs;
}

void FaultyEmulator::spoil(std::vector<uint8_t>& bytes) {
  for (uint8_t& byte : bytes) {
    if (random_() % 100 < kGarbagePercent) byte = static_cast<uint8_t>(random_());
  }
}

void FaultyEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  inner_.receive(silent(now) ? std::span<const uint8_t>{} : bytes, baud, now);
}

void FaultyEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  std::vector<uint8_t> said;
  inner_.advance(now, said);
  if (silent(now)) said.clear();
  if (board_.has(device_, FaultKind::garbage, now)) spoil(said);
  // What is under way comes late also when the fault is over: in order.
  const bool is_slow = board_.has(device_, FaultKind::slow, now);
  if (is_slow || !late_.empty()) {
    if (!said.empty()) late_.emplace_back(is_slow ? now + kLate : now, std::move(said));
    said.clear();
  }
  while (!late_.empty() && late_.front().first <= now) {
    out.insert(out.end(), late_.front().second.begin(), late_.front().second.end());
    late_.pop_front();
  }
  out.insert(out.end(), said.begin(), said.end());
}

Utime FaultyEmulator::next_event() const {
  const Utime next = inner_.next_event();
  return late_.empty() ? next : std::min(next, late_.front().first);
}

void FaultyEmulator::on_connection(bool connected, Utime now) {
  late_.clear();
  inner_.on_connection(connected, now);
}

}  // namespace marco::sim
