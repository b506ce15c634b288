#include "simulator/live/faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

constexpr double kLongestS = 1e6;  // times must not overflow

struct Named {
  const char* name;
  FaultKind kind;
  const char* meaning;
};
constexpr std::array<Named, 7> kKinds{{
    {"off", FaultKind::off, "its cable is cut: no bytes pass in either direction"},
    {"stuck", FaultKind::stuck,
     "repeats its last values; wheels and pan-tilt count but do not move"},
    {"garbage", FaultKind::garbage, "three of ten bytes it sends are random"},
    {"slow", FaultKind::slow, "its bytes arrive 0.5 s late"},
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
  require(spec.start_s >= 0.0 && spec.start_s <= kLongestS && spec.duration_s > 0.0 &&
              spec.duration_s <= kLongestS,
          "fault of '" + spec.device + "': start_s from 0 and duration_s above 0, to 1e6 s");
  constexpr std::size_t kMost = 1000;
  require(faults_.size() < kMost, "there already are 1000 faults");
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

}  // namespace marco::sim
