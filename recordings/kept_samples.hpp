#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <tuple>

#include "recordings/sample_reader.hpp"

namespace marco {

/// A recording that is read several times and opened once: its samples are kept in memory. If they
/// take more than the limit, none are kept: each pass opens the recording again, and the report
/// says so.
class KeptSamples : public files::SampleReader {
 public:
  using Open = std::function<std::unique_ptr<files::SampleReader>()>;

  /// @param open  called by the first next(); may throw
  KeptSamples(Open open, std::size_t most_bytes);

  std::optional<Sample> next() override;
  /// Of the last pass that reached the end.
  const files::InputReport& report() const override { return report_; }
  double progress() const override;

  /// Starts the next pass: next() gives the first sample.
  void rewind();
  /// The same, and keeps no further samples: no other pass follows.
  /// @throws std::logic_error from a rewind() that follows all the same.
  void rewind_for_the_last_time();

 private:
  /// The samples in their order, each in the memory that its own kind takes.
  template <class>
  struct Columns;
  template <class... Kinds>
  struct Columns<std::variant<Kinds...>> {
    std::deque<uint8_t> kinds;
    std::tuple<std::deque<Kinds>...> values;
  };

  std::optional<Sample> read_on();
  void keep(const Sample& sample);
  Sample kept_sample();

  Open open_;
  std::size_t most_bytes_;
  std::unique_ptr<files::SampleReader> source_;  ///< nullptr: not open, or read to its end
  Columns<Sample> kept_;
  std::size_t given_ = 0;                                                 ///< in this pass
  std::array<std::size_t, std::variant_size_v<Sample>> given_of_kind_{};  ///< of those kept
  std::size_t bytes_ = 0;
  bool has_ended_ = false;     ///< this pass
  bool is_complete_ = false;   ///< the whole recording is kept
  bool is_too_large_ = false;  ///< nothing is kept
  bool is_last_ = false;
  files::InputReport report_;
};

}  // namespace marco
