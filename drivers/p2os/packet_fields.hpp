#pragma once

#include "drivers/p2os/codec.hpp"

/// A packet's fields are listed once, in a function template fields(io, value): FieldWriter encodes
/// by it and FieldReader decodes.
namespace marco::drivers::p2os {

class FieldWriter {
 public:
  explicit FieldWriter(uint8_t id) { bytes_.push_back(id); }

  void u8(int value) { bytes_.push_back(static_cast<uint8_t>(value)); }
  void u16(int value) {
    u8(value & 0xFF);
    u8(value >> 8 & 0xFF);
  }
  void u15(int value) { u16(value & 0x7FFF); }
  void s32(int32_t value) {
    u16(value & 0xFFFF);
    u16(value >> 16 & 0xFFFF);
  }
  void text(const std::string& text) {
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  /// What nothing here depends on.
  void constant8(int value) { u8(value); }
  void constant16(int value) { u16(value); }
  /// The number of items, then `write(item)` of each.
  template <class Items, class Write>
  void list(const Items& items, const Write& write) {
    u8(static_cast<int>(items.size()));
    for (const auto& item : items) write(item);
  }
  Bytes packet() const { return encode_packet(bytes_); }

 private:
  Bytes bytes_;
};

class FieldReader {
 public:
  explicit FieldReader(std::span<const uint8_t> payload) : rest_(payload.subspan(1)) {}

  template <class Value>
  void u8(Value& value) {
    value = static_cast<Value>(byte());
  }
  template <class Value>
  void u16(Value& value) {
    const int low = byte();
    value = static_cast<Value>(low | byte() << 8);
  }
  void u15(uint16_t& value) {
    u16(value);
    value &= 0x7FFF;
  }
  void s32(int32_t& value) {
    uint32_t low = 0, high = 0;
    u16(low);
    u16(high);
    value = static_cast<int32_t>(low | high << 16);
  }
  void text(std::string& text) {
    text.clear();
    for (int c = byte(); c != 0; c = byte()) text += static_cast<char>(c);
  }
  void constant8(int /*value*/) { byte(); }
  void constant16(int /*value*/) {
    byte();
    byte();
  }
  template <class Items, class Read>
  void list(Items& items, const Read& read) {
    for (int left = byte(); left > 0; --left) read(items.emplace_back());
  }
  /// Whether the payload was long enough.
  bool good() const { return good_; }

 private:
  int byte() {
    if (rest_.empty()) {
      good_ = false;
      return 0;
    }
    const int value = rest_[0];
    rest_ = rest_.subspan(1);
    return value;
  }

  std::span<const uint8_t> rest_;
  bool good_ = true;
};

}  // namespace marco::drivers::p2os
