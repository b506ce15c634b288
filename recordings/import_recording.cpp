#include "recordings/import_recording.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"

namespace marco::logs {
namespace {

// The messages of samples as events, SENSOR_INFO repeated.
class EventSink {
 public:
  explicit EventSink(OutputFile& out) : out_(out) {}

  void add(const Sample& sample) {
    write(sample);
    if (const auto* info = std::get_if<SensorInfo>(&sample)) {
      infos_[info->channel] = *info;
      repeat_from_ = last_ + kRepeat;
    }
    if (infos_.empty() || last_ < repeat_from_) return;
    repeat_from_ = last_ + kRepeat;
    for (auto& [channel, info] : infos_) {
      info.utime = last_;
      write(info);
    }
  }
  int64_t events() const { return number_; }

 private:
  static constexpr Duration kRepeat = Duration::from_us(1000000);
  void write(const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    last_ = number_ == 0 ? message.utime : std::max(last_, message.utime);
    out_.write(files::event_header(number_++, last_, message.channel, message.bytes.size()));
    out_.write(message.channel);
    out_.write(message.bytes);
  }

  OutputFile& out_;
  int64_t number_ = 0;
  Utime last_;
  Utime repeat_from_;
  std::map<std::string, SensorInfo> infos_;
};

}  // namespace

ImportResult import_recording(const std::filesystem::path& in,
                              OutputFile& out,
                              const OnProgress& on_progress) {
  const auto recording = open_recording(in);
  EventSink sink(out);
  constexpr int64_t kSamplesBetweenProgress = 256;
  for (int64_t samples = 1; const auto sample = recording->next(); ++samples) {
    sink.add(*sample);
    if (samples % kSamplesBetweenProgress == 0) on_progress(recording->progress());
  }
  return {sink.events(), recording->report()};
}

}  // namespace marco::logs
