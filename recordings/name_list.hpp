#pragma once

#include <cstddef>
#include <string>

namespace marco {

/// Names for one line of a report: "a, b, c", of very many the first and how many there are.
class NameList {
 public:
  void add(const std::string& name) {
    constexpr std::size_t kShown = 40, kLongest = 200;
    if (++count_ <= kShown) text_ += (text_.empty() ? "" : ", ") + name.substr(0, kLongest);
    if (count_ > kShown) more_ = " and " + std::to_string(count_ - kShown) + " more";
  }
  bool empty() const { return count_ == 0; }
  std::string text() const { return text_ + more_; }

 private:
  std::size_t count_ = 0;
  std::string text_, more_;
};

}  // namespace marco
