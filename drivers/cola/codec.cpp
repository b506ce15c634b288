#include "drivers/cola/codec.hpp"

#include <algorithm>
#include <utility>

namespace marco::drivers::cola {
namespace {

constexpr char kBegin = 0x02, kEnd = 0x03;
constexpr std::string_view kBinaryMark = "\x02\x02\x02\x02";

bool is_text(std::string_view text) {
  return text.size() >= 3 && text[0] == 's' &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

Bytes encode_telegram(std::string_view text) {
  Bytes bytes{static_cast<uint8_t>(kBegin)};
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.push_back(static_cast<uint8_t>(kEnd));
  return bytes;
}

void TelegramParser::push(std::span<const uint8_t> bytes) {
  buffer_.erase(0, head_);
  head_ = 0;
  buffer_.append(bytes.begin(), bytes.end());
}

void TelegramParser::clear() {
  buffer_.clear();
  head_ = looked_ = 0;
  heard_binary_ = false;
}

void TelegramParser::drop(std::size_t count) {
  garbage_bytes_ += static_cast<int64_t>(count);
  head_ += count;
  looked_ = 0;
}

std::optional<Telegram> TelegramParser::next() {
  while (head_ < buffer_.size()) {
    const std::string_view rest = std::string_view(buffer_).substr(head_);
    const std::size_t begin = std::min(rest.find(kBegin), rest.size());
    if (begin > 0) {
      drop(begin);
      continue;
    }
    if (rest.starts_with(kBinaryMark)) {
      heard_binary_ = true;
      drop(kBinaryMark.size());
      continue;
    }
    const std::size_t end = rest.find(kEnd, looked_);
    if (end == std::string_view::npos) {
      looked_ = rest.size();
      if (rest.size() <= kMostText) return std::nullopt;
      drop(1);
      continue;
    }
    // A telegram that was cut off is followed by the next one.
    const std::size_t last_begin = rest.substr(0, end).rfind(kBegin);
    if (last_begin > 0) {
      drop(last_begin);
      continue;
    }
    const std::string_view text = rest.substr(1, end - 1);
    if (!is_text(text)) {
      drop(end + 1);
      continue;
    }
    Telegram telegram{std::string(text), rest.size() - end - 1};
    head_ += end + 1;
    looked_ = 0;
    heard_binary_ = false;
    return telegram;
  }
  return std::nullopt;
}

std::optional<std::string> refusal(std::string_view text) {
  if (!text.starts_with("sFA")) return std::nullopt;
  return std::string(text.substr(std::min<std::size_t>(4, text.size())));
}

std::string model_of(std::string_view identity) {
  for (const std::string_view family : {"TiM", "LMS"}) {
    const std::size_t at = identity.find(family);
    if (at == std::string_view::npos) continue;
    const std::string_view name = identity.substr(at);
    return std::string(name.substr(0, std::min(name.find(' '), name.size())));
  }
  return {};
}

double range_max_of(std::string_view model) {
  for (const auto& [beginning, range_m] :
       {std::pair{"TiM55", 10.0}, std::pair{"TiM56", 10.0}, std::pair{"TiM57", 25.0},
        std::pair{"LMS10", 20.0}, std::pair{"LMS11", 20.0}, std::pair{"LMS14", 40.0},
        std::pair{"LMS15", 50.0}}) {
    if (model.starts_with(beginning)) return range_m;
  }
  return 25.0;
}

}  // namespace marco::drivers::cola
