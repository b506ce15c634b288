#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "tests/fuzz/target.hpp"

/// Bytes from devices. The first byte of an input says how the rest reaches the codec: raw, or each
/// piece wrapped in a telegram whose checksum fits, since no fuzzer guesses those.
namespace marco::fuzz {

inline void append(Bytes& stream, std::span<const uint8_t> more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

/// The stream that an input means; `wrap` makes a telegram of a piece.
template <class Wrap>
Bytes stream_of(Input& input, bool wrapped, Wrap wrap) {
  Bytes stream;
  while (!input.empty()) append(stream, wrapped ? wrap(input.piece()) : Bytes());
  return stream;
}

/// Feeds a stream in pieces of `step` bytes and calls `drain` after each.
template <class Push, class Drain>
void feed(std::span<const uint8_t> stream, std::size_t step, Push push, Drain drain) {
  for (std::size_t at = 0; at < stream.size(); at += step) {
    push(stream.subspan(at, std::min(step, stream.size() - at)));
    drain();
  }
}

struct Way {
  bool wrapped;
  std::size_t step;
};
inline Way way_of(Input& input) {
  const uint8_t choice = input.byte();
  return {(choice & 1U) != 0, choice < 64 ? 1U + choice / 2U : 4096U};
}

template <class Wrap>
Bytes gather(Input& input, const Way& way, Wrap wrap) {
  if (way.wrapped) return stream_of(input, true, wrap);
  const auto rest = input.rest();
  return {rest.begin(), rest.end()};
}

}  // namespace marco::fuzz
