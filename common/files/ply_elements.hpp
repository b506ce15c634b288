#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/scalar_types.hpp"

namespace marco::files {

struct PlyProperty {
  std::string name;
  Scalar type = Scalar::float32;     ///< of a list: of its items
  std::optional<Scalar> count_type;  ///< of lists only
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  /// Names by index; a list's is empty, so that it is not found where a number is wanted.
  std::vector<std::string> number_names() const;
  std::optional<std::size_t> find_list(std::string_view name) const;
};

/// The elements of a PLY file, one after another: text, or binary of either byte order, of any
/// properties in any order. Not thread-safe.
class PlyElements {
 public:
  /// What is wanted of an element, by index of its properties.
  struct Wanted {
    std::vector<std::size_t> numbers;
    std::optional<std::size_t> list;
  };
  /// The wanted numbers of a row, in that order, and the wanted list's items.
  using Row = std::function<void(std::span<const double> numbers, std::span<const double> list)>;

  /// Reads the header.
  /// @param content  the file, which outlives this
  /// @param name  of the file, for messages
  /// @throws std::invalid_argument for what is no PLY, or a header that declares more than the file
  /// can hold.
  PlyElements(std::string_view content, std::string name);

  const std::vector<PlyElement>& elements() const { return elements_; }

  /// Reads the next of elements(), and calls `row` for each of its rows.
  /// @throws std::invalid_argument when the file ends in it, or a number cannot be read.
  void read_next(const Wanted& wanted, const Row& row);
  void skip_next();

 private:
  enum class Format : uint8_t { text, little, big };
  struct Step;

  std::string_view header_line();
  void read_header();
  void add_property(std::string_view words);
  void check_counts() const;
  void read_rows(const PlyElement& element, const Wanted& wanted, const Row& row);
  template <ByteOrder kOrder>
  void read_fixed_rows(const PlyElement& element, const Wanted& wanted, const Row& row);
  void take_list(double count, Scalar type, std::vector<double>* list);
  double take(Scalar type);
  double take_text();
  std::size_t bytes_left() const { return content_.size() - at_; }
  [[noreturn]] void fail(const std::string& what) const;

  std::string_view content_;
  std::string name_;
  std::size_t at_ = 0;
  Format format_ = Format::text;
  std::vector<PlyElement> elements_;
  std::size_t next_element_ = 0;
};

}  // namespace marco::files
