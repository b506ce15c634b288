#include "recordings/ros/ros_reader.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "recordings/ros/ros_plan.hpp"
#include "recordings/ros/ros_samples.hpp"
#include "recordings/ros/ros_survey.hpp"

namespace marco::ros {
namespace {

constexpr const char* kCutOff = "the recording ends inside a record: the recorder was killed";

// Where nothing can be mapped, what is wrong with the file may be why.
RosPlan planned(MessageSource& source, const RosOptions& options) {
  const RosSurvey seen = survey(source);
  try {
    return plan_of(seen, options);
  } catch (const std::invalid_argument& fault) {
    std::string text = fault.what();
    for (const std::string& note : source.notes()) text += "; " + note;
    if (source.damage().is_cut_off) text += std::string("; ") + kCutOff;
    throw std::invalid_argument(text);
  }
}

class RosReader : public files::QueuedReader {
 public:
  RosReader(std::unique_ptr<MessageSource> source, const RosOptions& options)
      : source_(std::move(source)) {
    samples_.emplace(planned(*source_, options), options);
    report_.format = source_->format();
    report_.paths = source_->paths();
    report_.notes = samples_->plan().notes;
    source_->select([this](const Topic& topic) { return samples_->wants(topic); });
  }

  double progress() const override { return source_->progress(); }

 private:
  bool read_piece() override {
    const auto message = source_->next();
    if (!message) return false;
    static constexpr const char* kKinds[] = {"sensor infos", "scans",    "odometry",
                                             "imu",          "pan-tilt", "true poses"};
    try {
      for (Sample& sample : samples_->take(*message)) {
        ++report_.given[kKinds[sample.index()]];
        queue(std::move(sample));
      }
    } catch (const std::invalid_argument& fault) {
      report_.drop(fault.what(), message->topic->name);
    }
    return true;
  }

  void finish_report() override {
    for (const std::string& line : source_->notes()) report_.notes.push_back(line);
    const Damage& damage = source_->damage();
    if (damage.is_cut_off) note("%s", kCutOff);
    if (damage.places == 0) return;
    report_.dropped["damaged stretches"] = damage.places;
    report_.places["damaged stretches"] = "byte " + std::to_string(damage.first_offset);
    note("%lld damaged bytes skipped", static_cast<long long>(damage.bytes));
  }

  std::unique_ptr<MessageSource> source_;
  std::optional<RosSamples> samples_;
};

}  // namespace

std::unique_ptr<files::SampleReader> open_ros(std::unique_ptr<MessageSource> source,
                                              const RosOptions& options) {
  constexpr const char* kBeams[] = {"first", "middle", "last"};
  require(std::any_of(std::begin(kBeams), std::end(kBeams),
                      [&](const char* beam) { return options.stamp == beam; }),
          "ros.stamp: first, middle or last, not '" + options.stamp + "'");
  return std::make_unique<RosReader>(std::move(source), options);
}

}  // namespace marco::ros
