#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Fuzz targets: functions that take any bytes and must neither crash, hang, leak nor eat memory.
/// Under the preset `fuzz` libFuzzer drives them (libfuzzer.cpp); in every other build the test
/// fuzz_regressions replays tests/fuzz/corpus/<target>/ through the same functions.
namespace marco::fuzz {

using Bytes = std::vector<uint8_t>;

struct Target {
  const char* name;
  void (*run)(std::span<const uint8_t>);
};

/// All targets linked into this program.
inline std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

struct Registration {
  Registration(const char* name, void (*run)(std::span<const uint8_t>)) {
    targets().push_back({name, run});
  }
};

/// A promise of the code under test is broken: libFuzzer sees a crash, the test a failure.
[[noreturn]] inline void broken(const char* promise) { throw promise; }
inline void promise(bool kept, const char* what) {
  if (!kept) broken(what);
}

/// Takes an input apart from its front; beyond the end everything is zero or empty.
class Input {
 public:
  explicit Input(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }
  uint8_t byte() {
    if (bytes_.empty()) return 0;
    const uint8_t value = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::span<const uint8_t> take(std::size_t count) {
    const std::span<const uint8_t> head = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(head.size());
    return head;
  }
  /// A piece whose length the next two bytes say.
  std::span<const uint8_t> piece() {
    const std::size_t low = byte();
    return take(low + 256U * byte());
  }
  std::span<const uint8_t> rest() { return take(bytes_.size()); }
  std::string text() {
    const auto all = rest();
    return {all.begin(), all.end()};
  }

 private:
  std::span<const uint8_t> bytes_;
};

}  // namespace marco::fuzz

/// MARCO_FUZZ(name) { ... use `bytes` ... }
#define MARCO_FUZZ(target)                                                               \
  static void fuzz_##target(std::span<const uint8_t> bytes);                             \
  static const marco::fuzz::Registration registration_##target(#target, &fuzz_##target); \
  static void fuzz_##target(std::span<const uint8_t> bytes)
