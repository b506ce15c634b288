#include "lcm_tools/schema/json.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "lcm_tools/base/format.hpp"

namespace marco::lcm_schema {
namespace {

template <class Number>
void append_number(Number value, std::string& out) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  out.append(digits.data(), end);
}

void append_value(const Tree& tree, const Node& node, std::size_t i, std::string& out) {
  if (node.primitive == Primitive::string) {
    append_json_string(tree.text(node), out);
  } else if (node.primitive == Primitive::boolean) {
    out += tree.integer(node, i) != 0 ? "true" : "false";
  } else if (node.primitive == Primitive::float32 || node.primitive == Primitive::float64) {
    const double value = tree.number(node, i);
    if (!std::isfinite(value)) {
      out += "null";
    } else if (node.primitive == Primitive::float32) {
      append_number(static_cast<float>(value), out);
    } else {
      append_number(value, out);
    }
  } else {
    append_number(tree.integer(node, i), out);
  }
}

class Writer {
 public:
  Writer(const Tree& tree, std::string& out, const JsonOptions& options)
      : tree_(tree), out_(out), options_(options) {}

  void write(std::size_t index) {
    const Node& node = tree_.nodes[index];
    switch (node.kind) {
      case NodeKind::value:
        append_value(tree_, node, 0, out_);
        break;
      case NodeKind::structure:
        write_fields(index);
        break;
      case NodeKind::values: {
        std::size_t element = 0;
        write_values(node, 0, element);
        break;
      }
      case NodeKind::list: {
        std::size_t child = index + 1;
        write_list(node, 0, child);
        break;
      }
    }
  }

 private:
  void write_fields(std::size_t index) {
    out_ += '{';
    const std::size_t end = tree_.nodes[index].after;
    for (std::size_t i = index + 1; i < end; i = tree_.nodes[i].after) {
      if (i > index + 1) out_ += ',';
      append_json_string(tree_.nodes[i].member->name, out_);
      out_ += ':';
      write(i);
    }
    out_ += '}';
  }

  bool cut(std::size_t written, std::size_t all) {
    if (written < options_.max_elements) return false;
    out_ +=
        std::string(written > 0 ? "," : "") + "\"... " + std::to_string(all - written) + " more\"";
    return true;
  }

  // How many parts the array has in this dimension. Of one that is empty inside, [[],[]], the outer
  // ones are written too, unless a few bytes claim more than fits into memory.
  std::size_t length(const Node& node, std::size_t dimension) const {
    constexpr std::size_t kMostEmpty = 1000;
    std::size_t outer = node.count == 0 ? 1 : 0;
    for (std::size_t d = 0; outer > 0 && d < node.member->dimensions.size(); ++d) {
      const std::size_t here = tree_.lengths[node.lengths_at + d];
      if (here == 0) break;
      outer *= here;
      if (outer > kMostEmpty) return 0;
    }
    return tree_.lengths[node.lengths_at + dimension];
  }

  void write_values(const Node& node, std::size_t dimension, std::size_t& element) {
    const std::size_t count = length(node, dimension);
    const bool last = dimension + 1 == node.member->dimensions.size();
    if (last && node.primitive == Primitive::byte && options_.bytes_as_base64) {
      out_ += '"' + to_base64(tree_.message.subspan(node.offset + element, count)) + '"';
      element += count;
      return;
    }
    const std::size_t first = element;
    const std::size_t stride = count == 0 ? 0 : inner_size(node, dimension);
    out_ += '[';
    for (std::size_t i = 0; i < count && !cut(i, count); ++i) {
      if (i > 0) out_ += ',';
      element = first + i * stride;
      if (last) {
        append_value(tree_, node, element, out_);
      } else {
        write_values(node, dimension + 1, element);
      }
    }
    element = first + count * stride;
    out_ += ']';
  }

  std::size_t inner_size(const Node& node, std::size_t dimension) const {
    std::size_t result = 1;
    for (std::size_t d = dimension + 1; d < node.member->dimensions.size(); ++d) {
      result *= tree_.lengths[node.lengths_at + d];
    }
    return result;
  }

  void write_list(const Node& node, std::size_t dimension, std::size_t& child) {
    const std::size_t count = length(node, dimension);
    const bool last = dimension + 1 == node.member->dimensions.size();
    out_ += '[';
    bool open = true;
    for (std::size_t i = 0; i < count; ++i) {
      if (open && cut(i, count)) open = false;
      const std::size_t keep = out_.size();
      if (i > 0) out_ += ',';
      if (!last) {
        write_list(node, dimension + 1, child);
      } else {
        if (open) write(child);
        child = tree_.nodes[child].after;
      }
      if (!open) out_.resize(keep);
    }
    out_ += ']';
  }

  const Tree& tree_;
  std::string& out_;
  const JsonOptions& options_;
};

// By its first byte; 0 for a byte that begins none.
std::size_t announced_length(uint8_t lead) {
  if (lead < 0x80) return 1;
  if (lead < 0xC2) return 0;
  if (lead < 0xE0) return 2;
  if (lead < 0xF0) return 3;
  return lead < 0xF5 ? 4 : 0;
}

// Length of the UTF-8 character at the front of `text`; 0 when it is none.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t lead = byte(0);
  const std::size_t length = announced_length(lead);
  if (length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return 0;
  }
  const bool overlong = (lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xF0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xED && byte(1) >= 0xA0;
  const bool beyond = lead == 0xF4 && byte(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

class SchemaWriter {
 public:
  SchemaWriter(const Schema& schema, const JsonOptions& options)
      : schema_(schema), options_(options) {}

  std::string structure(int index) {
    if (std::find(parents_.begin(), parents_.end(), index) != parents_.end()) return "{}";
    parents_.push_back(index);
    std::string out = R"({"type":"object","properties":{)";
    const Structure& type = schema_.structures()[static_cast<std::size_t>(index)];
    for (const Member& member : type.members) {
      if (&member != &type.members.front()) out += ',';
      append_json_string(member.name, out);
      out += ':' + field(member, 0);
    }
    parents_.pop_back();
    return out + "}}";
  }

 private:
  std::string field(const Member& member, std::size_t dimension) {
    const std::size_t left = member.dimensions.size() - dimension;
    if (left == 1 && member.primitive == Primitive::byte && options_.bytes_as_base64) {
      return R"({"type":"string","contentEncoding":"base64"})";
    }
    if (left > 0) return R"({"type":"array","items":)" + field(member, dimension + 1) + "}";
    if (!member.primitive) return structure(member.structure);
    switch (*member.primitive) {
      case Primitive::string:
        return R"({"type":"string"})";
      case Primitive::boolean:
        return R"({"type":"boolean"})";
      case Primitive::float32:
      case Primitive::float64:
        return R"({"type":"number"})";
      default:
        return R"({"type":"integer"})";
    }
  }

  const Schema& schema_;
  const JsonOptions& options_;
  std::vector<int> parents_;
};

}  // namespace

void append_json_string(std::string_view text, std::string& out) {
  out += '"';
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    const char c = text.front();
    if (length == 0) {
      out += "\xEF\xBF\xBD";
    } else if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += format("\\u%04x", static_cast<unsigned>(c));
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  out += '"';
}

void append_json(const Tree& tree, std::string& out, const JsonOptions& options) {
  if (tree.nodes.empty()) {
    out += "null";
  } else {
    Writer(tree, out, options).write(0);
  }
}

std::string json_schema(const Schema& schema, int structure, const JsonOptions& options) {
  return SchemaWriter(schema, options).structure(structure);
}

std::string to_base64(std::span<const uint8_t> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8U | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[(group >> (18 - 6 * k)) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace marco::lcm_schema
