#include "plan/drawing/xml_tags.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"

namespace marco::plan {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr const char* kCut = "is truncated: a tag has no end";

}  // namespace

std::string XmlTag::attribute(std::string_view wanted) const {
  const auto found = std::find_if(attributes.begin(), attributes.end(),
                                  [&](const auto& one) { return one.first == wanted; });
  if (found == attributes.end()) return {};
  constexpr std::pair<std::string_view, char> kEntities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
  std::string value;
  for (std::size_t i = 0; i < found->second.size();) {
    const std::string_view rest = found->second.substr(i);
    const auto* entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                      [&](const auto& one) { return rest.starts_with(one.first); });
    value += entity != std::end(kEntities) ? entity->second : rest.front();
    i += entity != std::end(kEntities) ? entity->first.size() : 1;
  }
  return value;
}

bool XmlTags::skip_over(std::string_view opening, std::string_view closing) {
  if (!text_.substr(at_).starts_with(opening)) return false;
  const std::size_t end = text_.find(closing, at_ + opening.size());
  require(end != std::string_view::npos, kCut);
  at_ = end + closing.size();
  return true;
}

// <!DOCTYPE ... [ ... ]>
void XmlTags::skip_declaration() {
  int depth = 0;
  for (; at_ < text_.size(); ++at_) {
    if (text_[at_] == '[' || text_[at_] == '<') ++depth;
    if (text_[at_] == ']' || text_[at_] == '>') --depth;
    if (depth == 0) break;
  }
  require(at_ < text_.size(), kCut);
  ++at_;
}

bool XmlTags::next(XmlTag& tag) {
  while (true) {
    at_ = text_.find('<', at_);
    if (at_ == std::string_view::npos) return false;
    if (skip_over("<!--", "-->") || skip_over("<![CDATA[", "]]>") || skip_over("<?", "?>"))
      continue;
    if (text_.substr(at_).starts_with("<!")) {
      skip_declaration();
      continue;
    }
    read_tag(tag);
    return true;
  }
}

void XmlTags::skip_blanks() { at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size()); }

void XmlTags::read_tag(XmlTag& tag) {
  constexpr std::string_view kEndsName = " \t\r\n/>=<";
  tag = {};
  ++at_;
  tag.closes = at_ < text_.size() && text_[at_] == '/';
  if (tag.closes) ++at_;
  const auto name = [&] {
    const std::size_t end = std::min(text_.find_first_of(kEndsName, at_), text_.size());
    const std::string_view found = text_.substr(at_, end - at_);
    at_ = end;
    return found;
  };
  tag.name = name();
  while (true) {
    skip_blanks();
    require(at_ < text_.size(), kCut);
    if (text_[at_] == '>') break;
    if (text_[at_] == '/') {
      tag.is_empty = true;
      ++at_;
      continue;
    }
    const std::string_view key = name();
    skip_blanks();
    require(!key.empty() && at_ < text_.size() && text_[at_] == '=', "contains a damaged tag");
    ++at_;
    skip_blanks();
    require(at_ < text_.size(), kCut);
    const char quote = text_[at_];
    require(quote == '"' || quote == '\'', "holds an attribute without quotes");
    const std::size_t end = text_.find(quote, at_ + 1);
    require(end != std::string_view::npos, kCut);
    tag.attributes.emplace_back(key, text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
  }
  ++at_;
}

}  // namespace marco::plan
