#include "drivers/process/line_watch.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/base/format.hpp"

namespace marco::drivers {
namespace {

constexpr double kBusyS = 0.5;
constexpr std::size_t kShownBytes = 16, kKeptBytes = 64;
constexpr double kMost = 0.9;

bool is_printable(uint8_t byte) {
  return (byte >= 0x20 && byte < 0x7f) || byte == '\r' || byte == '\n' || byte == '\t';
}

}  // namespace

void LineWatch::on_bytes(std::span<const uint8_t> bytes) {
  if (bytes.empty()) return;
  quiet_s_ = 0.0;
  count_ += static_cast<int64_t>(bytes.size());
  printable_ += std::count_if(bytes.begin(), bytes.end(), is_printable);
  zeros_ += std::count(bytes.begin(), bytes.end(), 0x00);
  ones_ += std::count(bytes.begin(), bytes.end(), 0xff);
  const std::size_t room = kKeptBytes - std::min(first_.size(), kKeptBytes);
  const auto kept = bytes.first(std::min(room, bytes.size()));
  first_.insert(first_.end(), kept.begin(), kept.end());
}

LineWatch::Trouble LineWatch::judge(bool answers, double now_s) {
  const double step_s = std::clamp(now_s - clock_s_.value_or(now_s), 0.0, kBusyS);
  clock_s_ = now_s;
  if (answers) {
    deaf_s_ = quiet_s_ = 0.0;
    count_ = printable_ = zeros_ = ones_ = 0;
    first_.clear();
    return trouble_ = Trouble::none;
  }
  deaf_s_ += step_s;
  quiet_s_ += step_s;
  if (quiet_s_ >= kSilentS) return trouble_ = Trouble::silent;
  if (deaf_s_ >= kGarbledS && count_ >= kGarbledBytes) return trouble_ = Trouble::garbled;
  if (trouble_ == Trouble::silent) trouble_ = Trouble::none;
  return trouble_;
}

std::string LineWatch::where() const {
  if (address_.starts_with("tcp:") || bauds_.empty()) return address_;
  std::string text = address_ + " at ";
  for (const int baud : bauds_) {
    if (baud != *bauds_.begin()) text += ", ";
    text += std::to_string(baud);
  }
  return text + " baud";
}

std::string LineWatch::guess() const {
  const auto most = [this](int64_t part) {
    return static_cast<double>(part) >= kMost * static_cast<double>(count_);
  };
  if (most(printable_)) {
    std::string line(first_.begin(), first_.end());
    line.erase(0, line.find_first_not_of("\r\n\t "));
    line.resize(std::min(line.find_first_of("\r\n"), line.size()));
    return "text, `" + line +
           "`: " + (line.starts_with("$G") ? "a GPS receiver?" : "another device?");
  }
  if (most(zeros_ + ones_)) {
    return "almost all 00 or ff: another baud rate, or a loose or crossed wire?";
  }
  return "another baud rate, or another device?";
}

std::string LineWatch::text() const {
  if (trouble_ == Trouble::none) return {};
  if (trouble_ == Trouble::silent) {
    return (count_ == 0 ? "no bytes at all from " : "no more bytes from ") + where() + ": is " +
           (address_.starts_with("tcp:")
                ? "the device behind it on, and its cable in?"
                : "the device powered, the cable in, TX and RX not crossed, the baud rate right?");
  }
  std::string sample;
  for (std::size_t i = 0; i < std::min(kShownBytes, first_.size()); ++i) {
    sample += format(" %02x", first_[i]);
  }
  return std::to_string(count_) + " bytes from " + where() + " make no telegram:" + sample +
         " ... " + guess();
}

}  // namespace marco::drivers
