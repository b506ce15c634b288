#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace marco::web {

/// The files that a browser gets: those of the page, and those of a map folder that its snapshot
/// names. No other path leads anywhere.
class Site {
 public:
  struct Answer {
    int status = 404;
    std::string type, body;
    std::filesystem::path file;  ///< to be sent instead of the body; empty = the body
  };

  /// A file of the page by its name; nothing for other names.
  using Page = std::function<std::optional<std::string_view>(std::string_view name)>;

  /// @param three  file of three.js; may be missing
  Site(Page page, std::filesystem::path three);

  /// The map folder that is shown. @param json  its snapshot; names its files as "files/NAME"
  void show_folder(std::filesystem::path folder, std::string json);

  /// @param target  of the request, with its query. @returns 404 for anything unknown.
  Answer get(std::string_view target) const;

 private:
  Page page_;
  std::filesystem::path three_, folder_;
  std::optional<std::string> snapshot_;
  std::set<std::string> named_;  // files of the folder
};

/// The value of `key` in a target's query; "" where there is none.
std::string query_value(std::string_view target, std::string_view key);

}  // namespace marco::web
