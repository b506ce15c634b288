#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace marco::plan {

/// An XML tag with its attributes.
struct XmlTag {
  std::string_view name;
  bool closes = false;    ///< an end tag
  bool is_empty = false;  ///< begins and ends at once
  std::vector<std::pair<std::string_view, std::string_view>> attributes;

  /// Without its name space.
  std::string_view local_name() const {
    const std::size_t colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
  }
  /// With the five standard entities replaced; "" where it is not there.
  std::string attribute(std::string_view wanted) const;
};

/// The tags of an XML text, one by one; text, comments, CDATA and declarations are ignored, and
/// entities that a document declares are not expanded. Checks no more than it needs.
class XmlTags {
 public:
  /// @param text  outlives the tags read
  explicit XmlTags(std::string_view text) : text_(text) {}
  /// @throws std::invalid_argument for a tag without its end.
  bool next(XmlTag& tag);

 private:
  bool skip_over(std::string_view opening, std::string_view closing);
  void skip_declaration();
  void read_tag(XmlTag& tag);
  void skip_blanks();

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace marco::plan
