#include "common/files/ply_elements.hpp"

#include <charconv>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

std::optional<Scalar> ply_scalar(std::string_view word) {
  struct Name {
    const char* word;
    Scalar type;
  };
  constexpr Name kNames[] = {
      {"char", Scalar::int8},      {"int8", Scalar::int8},       {"uchar", Scalar::uint8},
      {"uint8", Scalar::uint8},    {"short", Scalar::int16},     {"int16", Scalar::int16},
      {"ushort", Scalar::uint16},  {"uint16", Scalar::uint16},   {"int", Scalar::int32},
      {"int32", Scalar::int32},    {"uint", Scalar::uint32},     {"uint32", Scalar::uint32},
      {"float", Scalar::float32},  {"float32", Scalar::float32}, {"double", Scalar::float64},
      {"float64", Scalar::float64}};
  for (const Name& name : kNames) {
    if (word == name.word) return name.type;
  }
  return std::nullopt;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

}  // namespace

// What becomes of a property: numbers go to a slot, or nowhere.
struct PlyElements::Step {
  Scalar type;
  std::optional<Scalar> count_type;
  std::optional<std::size_t> slot;
  bool is_wanted_list;
};

std::vector<std::string> PlyElement::number_names() const {
  std::vector<std::string> names;
  for (const PlyProperty& property : properties) {
    names.push_back(property.count_type ? "" : property.name);
  }
  return names;
}

std::optional<std::size_t> PlyElement::find_list(std::string_view wanted) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].count_type && properties[i].name == wanted) return i;
  }
  return std::nullopt;
}

PlyElements::PlyElements(std::string_view content, std::string name)
    : content_(content), name_(std::move(name)) {
  read_header();
  check_counts();
}

void PlyElements::fail(const std::string& what) const {
  throw std::invalid_argument(name_ + ": " + what);
}

std::string_view PlyElements::header_line() {
  const std::size_t end = content_.find('\n', at_);
  if (end == std::string_view::npos) fail("not a PLY file: its header has no end");
  std::string_view line = content_.substr(at_, end - at_);
  at_ = end + 1;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

void PlyElements::read_header() {
  if (!content_.starts_with("ply\n") && !content_.starts_with("ply\r\n")) fail("no PLY");
  header_line();
  bool has_format = false;
  for (std::string_view line = header_line(); line != "end_header"; line = header_line()) {
    TextFields words(line);
    const std::string_view key = words.next();
    if (key == "format") {
      const std::string_view format = words.next();
      has_format =
          format == "ascii" || format == "binary_little_endian" || format == "binary_big_endian";
      if (format == "binary_little_endian") format_ = Format::little;
      if (format == "binary_big_endian") format_ = Format::big;
    } else if (key == "element") {
      const std::string_view name = words.next();
      const auto count = words.number<std::size_t>();
      if (!count) fail("'" + std::string(line.substr(0, 80)) + "' has no number");
      elements_.push_back({std::string(name), *count, {}});
    } else if (key == "property") {
      add_property(line);
    }
  }
  if (!has_format) fail("its format is none of ascii, binary_little_endian, binary_big_endian");
}

void PlyElements::add_property(std::string_view line) {
  TextFields words(line);
  words.next();
  std::string_view word = words.next();
  PlyProperty property;
  const bool is_list = word == "list";
  if (is_list) {
    property.count_type = ply_scalar(words.next());
    word = words.next();
  }
  const auto type = ply_scalar(word);
  if (!type || (is_list && !property.count_type) || elements_.empty()) {
    fail("'" + std::string(line.substr(0, 80)) + "' is not a property of an element");
  }
  property.type = *type;
  property.name = words.next();
  elements_.back().properties.push_back(std::move(property));
}

// Before memory is allocated for them.
void PlyElements::check_counts() const {
  constexpr std::size_t kDigitAndBlank = 2;
  for (const PlyElement& element : elements_) {
    std::size_t least_bytes = 0;
    for (const PlyProperty& property : element.properties) {
      least_bytes += format_ == Format::text ? kDigitAndBlank
                                             : size_of(property.count_type.value_or(property.type));
    }
    if (least_bytes > 0 && element.count > (bytes_left() + 1) / least_bytes) {
      fail("its header declares " + std::to_string(element.count) + " of '" + element.name +
           "', more than the file contains");
    }
  }
}

double PlyElements::take_text() {
  while (at_ < content_.size() && is_blank(content_[at_])) ++at_;
  if (at_ < content_.size() && content_[at_] == '+') ++at_;
  double value = 0.0;
  const char* const end = content_.data() + content_.size();
  const auto parsed = std::from_chars(content_.data() + at_, end, value);
  if (at_ == content_.size()) fail("ends before its last element");
  if (parsed.ec != std::errc{} || (parsed.ptr != end && !is_blank(*parsed.ptr))) {
    fail("byte " + std::to_string(at_) + ": no number");
  }
  at_ = static_cast<std::size_t>(parsed.ptr - content_.data());
  return value;
}

double PlyElements::take(Scalar type) {
  if (format_ == Format::text) return take_text();
  const std::size_t size = size_of(type);
  if (bytes_left() < size) fail("ends before its last element");
  const char* const from = content_.data() + at_;
  at_ += size;
  return format_ == Format::little ? load<ByteOrder::little>(from, type)
                                   : load<ByteOrder::big>(from, type);
}

// Binary rows without lists are of one length: nothing but the wanted numbers is looked at.
template <ByteOrder kOrder>
void PlyElements::read_fixed_rows(const PlyElement& element, const Wanted& wanted, const Row& row) {
  std::vector<std::size_t> offsets;
  std::size_t row_bytes = 0;
  for (const PlyProperty& property : element.properties) {
    offsets.push_back(row_bytes);
    row_bytes += size_of(property.type);
  }
  struct Pick {
    std::size_t offset;
    Scalar type;
  };
  std::vector<Pick> picks;
  for (const std::size_t i : wanted.numbers)
    picks.push_back({offsets[i], element.properties[i].type});
  if (bytes_left() / row_bytes < element.count) fail("ends before its last element");
  std::vector<double> numbers(picks.size());
  for (std::size_t i = 0; i < element.count; ++i) {
    const char* const from = content_.data() + at_;
    for (std::size_t k = 0; k < picks.size(); ++k) {
      numbers[k] = load<kOrder>(from + picks[k].offset, picks[k].type);
    }
    at_ += row_bytes;
    row(numbers, {});
  }
}

// `count` as the file has it, which may be anything.
void PlyElements::take_list(double count, Scalar type, std::vector<double>* list) {
  if (!(count >= 0.0 && count <= static_cast<double>(bytes_left()))) {
    fail("byte " + std::to_string(at_) + ": a list is longer than the file");
  }
  if (list != nullptr) list->clear();
  for (std::size_t left = static_cast<std::size_t>(count); left > 0; --left) {
    const double item = take(type);
    if (list != nullptr) list->push_back(item);
  }
}

void PlyElements::read_rows(const PlyElement& element, const Wanted& wanted, const Row& row) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    const auto slot = std::find(wanted.numbers.begin(), wanted.numbers.end(), i);
    steps.push_back({property.type, property.count_type, std::nullopt, wanted.list == i});
    if (slot != wanted.numbers.end()) {
      steps.back().slot = static_cast<std::size_t>(slot - wanted.numbers.begin());
    }
  }
  std::vector<double> numbers(wanted.numbers.size()), list;
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const Step& step : steps) {
      const double value = take(step.count_type.value_or(step.type));
      if (!step.count_type) {
        if (step.slot) numbers[*step.slot] = value;
        continue;
      }
      take_list(value, step.type, step.is_wanted_list ? &list : nullptr);
    }
    row(numbers, list);
  }
}

void PlyElements::read_next(const Wanted& wanted, const Row& row) {
  require(next_element_ < elements_.size(), "PlyElements: there is no further element");
  const PlyElement& element = elements_[next_element_++];
  if (element.properties.empty()) return;
  const bool has_lists = std::any_of(element.properties.begin(), element.properties.end(),
                                     [](const PlyProperty& p) { return p.count_type.has_value(); });
  if (has_lists || format_ == Format::text) {
    read_rows(element, wanted, row);
  } else if (format_ == Format::little) {
    read_fixed_rows<ByteOrder::little>(element, wanted, row);
  } else {
    read_fixed_rows<ByteOrder::big>(element, wanted, row);
  }
}

void PlyElements::skip_next() {
  read_next({}, [](std::span<const double>, std::span<const double>) {});
}

}  // namespace marco::files
