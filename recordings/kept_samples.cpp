#include "recordings/kept_samples.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace marco {
namespace {

std::size_t heap_bytes(const LaserScan& scan) {
  return scan.channel.size() + sizeof(float) * (scan.ranges_m.size() + scan.bearings_rad.size() +
                                                scan.time_offsets_s.size());
}

template <class Kind>
std::size_t heap_bytes(const Kind& /*sample*/) {
  return 0;
}

}  // namespace

KeptSamples::KeptSamples(Open open, std::size_t most_bytes)
    : open_(std::move(open)), most_bytes_(most_bytes) {}

std::optional<Sample> KeptSamples::next() {
  if (given_ < kept_.kinds.size()) return kept_sample();
  if (is_complete_ || has_ended_) return std::nullopt;
  return read_on();
}

std::optional<Sample> KeptSamples::read_on() {
  if (source_ == nullptr) source_ = open_();
  std::optional<Sample> sample = source_->next();
  if (sample) {
    ++given_;
    if (!is_last_ && !is_too_large_) keep(*sample);
    return sample;
  }
  has_ended_ = true;
  is_complete_ = !is_last_ && !is_too_large_;
  report_ = source_->report();
  if (is_too_large_) {
    report_.notes.push_back("takes more than " + std::to_string(most_bytes_ / 1'000'000) +
                            " MB of memory: it is read from the disk for each pass");
  }
  source_.reset();
  return std::nullopt;
}

void KeptSamples::keep(const Sample& sample) {
  std::visit(
      [this](const auto& value) {
        bytes_ += sizeof value + heap_bytes(value);
        std::get<std::deque<std::decay_t<decltype(value)>>>(kept_.values).push_back(value);
      },
      sample);
  kept_.kinds.push_back(static_cast<uint8_t>(sample.index()));
  ++given_of_kind_[sample.index()];
  is_too_large_ = bytes_ > most_bytes_;
  if (is_too_large_) kept_ = {};
}

Sample KeptSamples::kept_sample() {
  const std::size_t kind = kept_.kinds[given_++];
  const std::size_t index = given_of_kind_[kind]++;
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    Sample sample;
    (void)((I == kind && (sample = std::get<I>(kept_.values)[index], true)) || ...);
    return sample;
  }
  (std::make_index_sequence<std::variant_size_v<Sample>>{});
}

double KeptSamples::progress() const {
  const double read = source_ != nullptr ? source_->progress() : 1.0;
  const auto known = static_cast<double>(std::max<std::size_t>(1, kept_.kinds.size()));
  return read * std::min(1.0, static_cast<double>(given_) / known);
}

void KeptSamples::rewind() {
  if (is_last_) throw std::logic_error("KeptSamples: rewound after the last time");
  given_ = 0;
  given_of_kind_ = {};
  has_ended_ = false;
  if (is_too_large_) source_.reset();
}

void KeptSamples::rewind_for_the_last_time() {
  rewind();
  is_last_ = true;
}

}  // namespace marco
