#include "slam/process/checkpoint_writer.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace marco::slam {

bool CheckpointWriter::is_due(Utime utime) {
  if (!saved_) saved_ = utime;
  if (std::abs((utime - *saved_).seconds()) < every_s_ || job_.busy()) return false;
  saved_ = utime;
  return true;
}

void CheckpointWriter::write_in_foreground() {
  if (const std::string failure = job_.wait(); !failure.empty()) drops_.count(failure);
  in_background_ = false;
}

void CheckpointWriter::write(std::function<void()> job) {
  const auto quietly = [job = std::move(job)]() -> std::string {
    try {
      job();
      return "";
    } catch (const std::runtime_error&) {  // a full disk must not end the mapping
      return "checkpoint: cannot be written";
    }
  };
  const auto count = [this](const std::string& failure) {
    if (!failure.empty()) drops_.count(failure);
  };
  if (!in_background_) return count(quietly());
  count(job_.take_reply());
  job_.start(quietly);
}

}  // namespace marco::slam
