#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "lcm_tools/process/config.hpp"

namespace marco::process {
namespace {

constexpr std::size_t kTextWidth = 100;

std::string text_of(bool value) { return value ? "true" : "false"; }

std::string text_of(int value) { return std::to_string(value); }

// toml++ would print 17 digits; this is the shortest text that reads back the same.
std::string text_of(double value) {
  char digits[32];
  std::string text(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  const bool is_whole = text.find_first_not_of("-0123456789") == std::string::npos;
  return is_whole ? text + ".0" : text;
}

std::string text_of(const std::string& value) {
  std::ostringstream text;
  text << toml::value<std::string>(value);
  return text.str();
}

template <class T>
std::string text_of(const std::vector<T>& values) {
  std::string text = "[";
  for (const T& value : values) text += (text.size() > 1 ? ", " : "") + text_of(value);
  return text + "]";
}

struct Entry {
  std::string name;
  std::string text;
  Limits limits = {};
  std::string_view about = {};
  bool advanced = false;
};

struct Section {
  std::string name;
  bool is_item = false;  // of a list of tables
  std::vector<Entry> entries = {};
  std::vector<Section> sections = {};
};

class SectionWriter final : public OptionVisitor {
 public:
  Section take() { return std::move(levels_.front()); }

 protected:
  void field(const Setting& setting) override {
    std::string text = std::visit([](const auto* value) { return text_of(*value); }, setting.value);
    levels_.back().entries.push_back({std::string(setting.name), std::move(text), setting.limits,
                                      setting.about, setting.advanced});
  }
  bool enter(std::string_view name, int item) override {
    levels_.push_back({std::string(name), item != kNoItem});
    return true;
  }
  void leave() override {
    Section done = std::move(levels_.back());
    levels_.pop_back();
    levels_.back().sections.push_back(std::move(done));
  }
  std::size_t enter_list(std::string_view name, std::size_t size) override {
    if (size == 0) levels_.back().entries.push_back({std::string(name), "[]"});
    return size;
  }

 private:
  std::vector<Section> levels_ = std::vector<Section>(1);
};

Section sections_of(const detail::Fields& fields) {
  SectionWriter writer;
  fields(writer);
  return writer.take();
}

bool has_default(const Entry& entry, const Section* defaults) {
  if (defaults == nullptr) return false;
  for (const Entry& other : defaults->entries) {
    if (other.name == entry.name) return other.text == entry.text;
  }
  return false;
}

/// What `defaults` has in place of section.sections[at].
const Section* counterpart(const Section& section, std::size_t at, const Section* defaults) {
  if (defaults == nullptr) return nullptr;
  const auto is_named = [&](const Section& other) {
    return other.name == section.sections[at].name;
  };
  auto before = std::count_if(section.sections.begin(),
                              section.sections.begin() + static_cast<std::ptrdiff_t>(at), is_named);
  for (const Section& other : defaults->sections) {
    if (is_named(other) && before-- == 0) return &other;
  }
  return nullptr;
}

std::string limits_text(const Limits& limits) {
  const bool above = limits.min == kPositive.min;
  if (above && std::isinf(limits.max)) return " [> 0]";
  if (std::isinf(limits.min) && std::isinf(limits.max)) return "";
  const auto bound = [](double value) {
    const std::string text = text_of(value);
    return text.ends_with(".0") ? text.substr(0, text.size() - 2) : text;
  };
  if (std::isinf(limits.max)) return " [>= " + bound(limits.min) + "]";
  return " [" + bound(limits.min) + " to " + bound(limits.max) + "]";
}

std::string comment(const std::string& text, const std::string& indent) {
  std::string lines, line;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!line.empty() && indent.size() + line.size() + word.size() + 3 > kTextWidth) {
      lines += indent + "#" + line + "\n";
      line.clear();
    }
    line += " " + word;
  }
  return lines + indent + "#" + line + "\n";
}

class TextWriter {
 public:
  explicit TextWriter(Printed which) : which_(which) {}
  void write(const Section& section, const Section* defaults, const std::string& path, int depth) {
    const std::string indent(static_cast<std::size_t>(4 * depth), ' ');
    std::string entries;
    for (const Entry& entry : section.entries) {
      const bool is_default = has_default(entry, defaults);
      if (is_default && which_ == Printed::changed) continue;
      if (is_default && entry.advanced && which_ == Printed::common) continue;
      if (!entry.about.empty() && which_ != Printed::changed) {
        entries += comment(std::string(entry.about) + limits_text(entry.limits), indent);
      }
      entries += indent + entry.name + " = " + entry.text + "\n";
    }
    // An item of a list counts even where nothing in it is printed.
    if (!path.empty() && (!entries.empty() || section.is_item)) {
      text_ += text_.empty() ? "" : "\n";
      text_ += indent + (section.is_item ? "[[" + path + "]]\n" : "[" + path + "]\n");
    }
    text_ += entries;
    for (std::size_t i = 0; i < section.sections.size(); ++i) {
      const Section& inner = section.sections[i];
      write(inner, counterpart(section, i, defaults),
            path.empty() ? inner.name : path + "." + inner.name, path.empty() ? 0 : depth + 1);
    }
  }
  const std::string& text() const { return text_; }

 private:
  Printed which_;
  std::string text_;
};

}  // namespace

namespace detail {

std::string print(const Fields& fields, const Fields& defaults, Printed which) {
  const Section before = sections_of(defaults);
  TextWriter writer(which);
  writer.write(sections_of(fields), &before, "", 0);
  return writer.text();
}

}  // namespace detail
}  // namespace marco::process
