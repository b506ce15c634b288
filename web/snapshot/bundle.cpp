#include "web/snapshot/bundle.hpp"

#include <regex>
#include <set>
#include <sstream>

#include "lcm_tools/base/check.hpp"

namespace marco::web {
namespace {

class Bundler {
 public:
  explicit Bundler(const std::function<std::optional<std::string_view>(std::string_view)>& text_of)
      : text_of_(text_of) {}

  void add(const std::string& name) {
    if (done_.count(name) != 0) return;
    require(open_.insert(name).second, name + ": modules import each other in a cycle");
    const auto text = text_of_(name);
    require(text.has_value(), name + ": no such module");
    std::string body, exported;
    std::istringstream lines{std::string(*text)};
    for (std::string line; std::getline(lines, line);) body += take(name, line, exported) + "\n";
    out_ += "modules[\"" + name + "\"] = (() => {\n" + body + "return {" + exported + "};\n})();\n";
    open_.erase(name);
    done_.insert(name);
  }
  std::string finish() const { return "\"use strict\";\n{\nconst modules = {};\n" + out_ + "}\n"; }

 private:
  // A line as it stands in the bundle. Adds what it imports before this module.
  std::string take(const std::string& name, const std::string& line, std::string& exported) {
    static const std::regex kImport(R"re(^import (\{[^}]*\}) from "\./([a-z0-9_]+\.js)";$)re");
    static const std::regex kExport(R"(^export (async function|function|class|const) (\w+))");
    std::smatch found;
    if (std::regex_search(line, found, kImport)) {
      const std::string what = found[1], from = found[2];
      add(from);
      return "const " + what + " = modules[\"" + from + "\"];";
    }
    if (std::regex_search(line, found, kExport)) {
      exported += found[2].str() + ", ";
      return line.substr(std::string_view("export ").size());
    }
    require(!line.starts_with("import") && !line.starts_with("export"),
            name + ": cannot be bundled: " + line);
    return line;
  }

  const std::function<std::optional<std::string_view>(std::string_view)>& text_of_;
  std::set<std::string> open_, done_;
  std::string out_;
};

}  // namespace

std::string bundle_modules(
    const std::string& entry,
    const std::function<std::optional<std::string_view>(std::string_view)>& text_of) {
  Bundler bundler(text_of);
  bundler.add(entry);
  return bundler.finish();
}

}  // namespace marco::web
