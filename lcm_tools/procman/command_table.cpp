#include "lcm_tools/procman/command_table.hpp"

#include <map>

namespace marco::procman {
namespace {

constexpr int64_t kSilentUs = 5'000'000;

struct Node {
  std::map<std::string, Node> groups;
  std::vector<const SheriffCommand*> commands;
};

Node build_tree(const SheriffState& sheriff) {
  Node root;
  for (const auto& [id, command] : sheriff.commands()) {
    Node* node = &root;
    for (const std::string& part : path_parts(command.spec.group)) node = &node->groups[part];
    node->commands.push_back(&command);
  }
  return root;
}

TableRow command_row(const SheriffCommand& command, int depth, bool silent) {
  TableRow row;
  row.depth = depth;
  row.name = row.target = command.spec.id;
  row.deputy = command.deputy;
  row.status = status_text(command.status());
  row.colour = colour_of(command.status());
  row.exec = command.spec.exec;
  if (silent && command.reported) {
    row.status += "?";
    row.colour = StatusColour::grey;
  }
  if (command.reported && command.reported->pid != 0) {
    row.cpu_usage = command.reported->cpu_usage;
    row.rss_bytes = command.reported->mem_rss_bytes;
  }
  return row;
}

class TableBuilder {
 public:
  TableBuilder(const SheriffState& sheriff, const std::set<std::string>& folded, int64_t now_us)
      : sheriff_(sheriff), folded_(folded), now_us_(now_us) {}

  /// Appends the members' rows; `sum`, the group's own row, summarizes them.
  void add_members(const Node& node, int depth, TableRow& sum) {
    for (const SheriffCommand* command : node.commands) {
      rows.push_back(command_row(*command, depth, is_silent(command->deputy)));
      join(sum, rows.back());
    }
    for (const auto& [name, inner] : node.groups) {
      const std::size_t at = rows.size();
      TableRow group;
      group.is_group = true;
      group.depth = depth;
      group.name = name;
      group.target = sum.target.empty() ? name : sum.target + "/" + name;
      group.folded = folded_.contains(group.target);
      rows.push_back(group);
      add_members(inner, depth + 1, group);
      if (group.folded) rows.resize(at + 1);
      rows[at] = group;
      join(sum, group);
    }
  }

  std::vector<TableRow> rows;

 private:
  bool is_silent(const std::string& deputy) const {
    const auto at = sheriff_.deputies().find(deputy);
    return at != sheriff_.deputies().end() && now_us_ - at->second.heard_us > kSilentUs;
  }

  static void join(TableRow& sum, const TableRow& member) {
    if (sum.status.empty()) {
      sum.status = member.status;
      sum.colour = member.colour;
      sum.deputy = member.deputy;
    }
    if (sum.status != member.status) {
      sum.status = "Mixed";
      sum.colour = sum.colour == StatusColour::red || member.colour == StatusColour::red
                       ? StatusColour::red
                       : StatusColour::yellow;
    }
    if (sum.deputy != member.deputy) sum.deputy = "";
    sum.cpu_usage += member.cpu_usage;
    sum.rss_bytes += member.rss_bytes;
  }

  const SheriffState& sheriff_;
  const std::set<std::string>& folded_;
  int64_t now_us_;
};

}  // namespace

StatusColour colour_of(Status status) {
  switch (status) {
    case Status::starting:
    case Status::restarting:
      return StatusColour::orange;
    case Status::running:
      return StatusColour::green;
    case Status::stopping:
      return StatusColour::yellow;
    case Status::stopped_error:
      return StatusColour::red;
    case Status::unknown:
      return StatusColour::grey;
    case Status::stopped_ok:
      break;
  }
  return StatusColour::none;
}

std::vector<TableRow> table_rows(const SheriffState& sheriff,
                                 const std::set<std::string>& folded,
                                 int64_t now_us) {
  TableBuilder builder(sheriff, folded, now_us);
  TableRow all;
  builder.add_members(build_tree(sheriff), 0, all);
  return builder.rows;
}

}  // namespace marco::procman
