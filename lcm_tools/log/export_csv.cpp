#include "lcm_tools/log/export_csv.hpp"

#include <charconv>
#include <map>
#include <memory>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "lcm_tools/log/export_json_lines.hpp"

namespace marco::logs {
namespace {

using lcm_schema::Node;
using lcm_schema::NodeKind;
using lcm_schema::Primitive;
using lcm_schema::Tree;

constexpr uint32_t kMostColumns = 64;

bool is_fixed(const Node& node) {
  if (node.count > kMostColumns || node.member == nullptr) return node.member == nullptr;
  for (const lcm_schema::Dimension& dimension : node.member->dimensions) {
    if (dimension.constant <= 0) return false;
  }
  return true;
}

void append_quoted(std::string_view text, std::string& row) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    row += text;
    return;
  }
  row += '"';
  for (const char c : text) {
    if (c == '"') row += '"';
    row += c;
  }
  row += '"';
}

void append_value(const Tree& tree, const Node& node, std::size_t element, std::string& row) {
  char text[40];
  std::to_chars_result end{};
  switch (node.primitive) {
    case Primitive::string:
      append_quoted(tree.text(node), row);
      return;
    case Primitive::float32:
      end = std::to_chars(text, text + sizeof text, static_cast<float>(tree.number(node, element)));
      break;
    case Primitive::float64:
      end = std::to_chars(text, text + sizeof text, tree.number(node, element));
      break;
    default:
      end = std::to_chars(text, text + sizeof text, tree.integer(node, element));
  }
  row.append(text, end.ptr);
}

// All values at and below node `at` as one cell.
void append_cell(const Tree& tree, std::size_t at, std::string& row) {
  const Node& top = tree.nodes[at];
  if (top.kind == NodeKind::values && top.primitive == Primitive::byte) {
    row += to_base64(tree.message.subspan(top.offset, top.bytes));
    return;
  }
  std::string cell;
  for (std::size_t i = at; i < top.after; ++i) {
    const Node& node = tree.nodes[i];
    const std::size_t count = node.kind == NodeKind::values  ? node.count
                              : node.kind == NodeKind::value ? 1
                                                             : 0;
    for (std::size_t element = 0; element < count; ++element) {
      if (!cell.empty()) cell += ' ';
      append_value(tree, node, element, cell);
    }
  }
  append_quoted(cell, row);
}

// Calls for each cell of a message: `single(node, element)` or `whole(node)`.
template <class Single, class Whole>
void for_each_cell(const Tree& tree, Single&& single, Whole&& whole) {
  for (std::size_t i = 1; i < tree.nodes.size();) {
    const Node& node = tree.nodes[i];
    const bool bytes = node.kind == NodeKind::values && node.primitive == Primitive::byte;
    const bool one_cell = (node.kind == NodeKind::values || node.kind == NodeKind::list) &&
                          (bytes || !is_fixed(node));
    if (one_cell) {
      whole(i);
      i = node.after;
      continue;
    }
    if (node.kind == NodeKind::value) single(i, std::size_t{0});
    for (std::size_t element = 0; node.kind == NodeKind::values && element < node.count;
         ++element) {
      single(i, element);
    }
    ++i;
  }
}

std::string header_of(const Tree& tree) {
  std::string row = "event,time_us";
  for_each_cell(
      tree,
      [&](std::size_t node, std::size_t element) {
        row += ',';
        row += lcm_schema::value_name(tree, static_cast<int>(node), element);
      },
      [&](std::size_t node) {
        row += ',';
        row += tree.path(static_cast<int>(node));
      });
  return row + "\n";
}

std::string row_of(const DecodedEvent& event) {
  std::string row =
      std::to_string(event.head.number) + "," + std::to_string(event.head.event_time.us);
  for_each_cell(
      event.tree,
      [&](std::size_t node, std::size_t element) {
        row += ',';
        append_value(event.tree, event.tree.nodes[node], element, row);
      },
      [&](std::size_t node) {
        row += ',';
        append_cell(event.tree, node, row);
      });
  return row + "\n";
}

}  // namespace

std::string file_name_of(std::string_view channel) {
  std::string name(channel);
  for (char& c : name) {
    if (c == '/' || c == '\\') c = '_';
  }
  if (!name.empty() && name.front() == '.') name.front() = '_';
  return name;
}

CsvResult export_csv(WalkInput& input,
                     const Types& types,
                     const std::filesystem::path& folder,
                     Existing existing,
                     const OnProgress& on_progress) {
  OutputFolder results(folder, existing, "export-csv", input.path);
  struct Table {
    std::string name;
    std::unique_ptr<files::OutputFile> file;
  };
  std::map<std::pair<std::string, int>, Table> tables;
  std::map<std::string, int> tables_of_channel;
  CsvResult result;
  constexpr std::size_t kMostTables = 400;  // open files
  result.walk = walk_log(
      input, types,
      [&](const DecodedEvent& event) {
        if (event.structure < 0) return;
        const std::string channel(event.head.channel);
        Table& table = tables[{channel, event.structure}];
        if (!table.file) {
          require(tables.size() <= kMostTables,
                  "more than 400 channels: choose some with --channel");
          table.name = file_name_of(channel);
          if (tables_of_channel[channel]++ > 0) {
            const auto index = static_cast<std::size_t>(event.structure);
            table.name += "." + types.schema().structures()[index].name;
          }
          table.name += ".csv";
          table.file = std::make_unique<files::OutputFile>(results.path() / table.name,
                                                           files::Appears::when_renamed);
          table.file->write(std::string_view(header_of(event.tree)));
          result.files.push_back(table.name);
        }
        table.file->write(std::string_view(row_of(event)));
      },
      on_progress);
  for (auto& [key, table] : tables) {
    if (table.file) table.file->finish();
  }
  results.commit();
  return result;
}

}  // namespace marco::logs
