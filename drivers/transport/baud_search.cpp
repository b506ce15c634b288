#include "drivers/transport/baud_search.hpp"

#include <utility>

namespace marco::drivers {

BaudSearch::BaudSearch(int wanted, const std::vector<int>& others) : rates_{wanted} {
  for (const int rate : others) {
    if (rate != wanted) rates_.push_back(rate);
  }
}

int BaudSearch::next() {
  if (std::exchange(started_, true)) index_ = (index_ + 1) % rates_.size();
  return current();
}

void BaudSearch::restart() {
  index_ = 0;
  started_ = false;
}

bool BaudSearch::drop_current() {
  rates_.erase(rates_.begin() + static_cast<std::ptrdiff_t>(index_));
  restart();
  return !rates_.empty();
}

}  // namespace marco::drivers
