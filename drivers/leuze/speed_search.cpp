#include "drivers/leuze/speed_search.hpp"

#include <utility>

namespace marco::drivers::leuze {

SpeedSearch::SpeedSearch(int wanted) : rates_{wanted} {
  for (const int rate : {57'600, 115'200, 38'400, 19'200, 9600}) {
    if (wanted != 0 && rate != wanted) rates_.push_back(rate);
  }
}

void SpeedSearch::next(bool lost) {
  const bool bytes_came = std::exchange(any_byte_, false);
  if (lost) return;
  if (!understood_) {
    rate_ = (rate_ + 1) % rates_.size();
    return;
  }
  if (rate_ != *understood_ || !bytes_came) {
    rate_ = *understood_;
    return;
  }
  other_ = (other_ + 1) % rates_.size();
  if (other_ == *understood_) other_ = (other_ + 1) % rates_.size();
  rate_ = other_;
}

}  // namespace marco::drivers::leuze
