#include "lcm_tools/files/result_list.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "lcm_tools/files/folder_lock.hpp"
#include "lcm_tools/files/output_file.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;

// "SIZE TIME", by which a file is known again; "" when it is not there or no file.
std::string state_of(const fs::path& path) {
  struct stat status = {};
  if (lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return "";
  return std::to_string(status.st_size) + " " + std::to_string(status.st_mtim.tv_sec) + "." +
         std::to_string(status.st_mtim.tv_nsec);
}

bool is_plain(const std::string& name) { return name.find('\n') == std::string::npos; }

}  // namespace

std::string list_name(const std::string& owner) { return ".marco-" + owner; }

std::vector<std::string> files_below(const fs::path& folder, std::size_t most) {
  std::vector<std::string> names;
  fs::recursive_directory_iterator entry(folder), end;
  for (; entry != end; ++entry) {
    const std::string name = entry->path().filename().string();
    if (name == kWorkFolder) entry.disable_recursion_pending();
    if (name == kWorkMark || name == kWorkFolder) continue;
    if (entry->symlink_status().type() == fs::file_type::directory) continue;
    if (names.size() > most) break;
    names.push_back(entry->path().lexically_relative(folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void write_result_list(const fs::path& folder,
                       const std::string& owner,
                       const fs::path& earlier,
                       const std::vector<std::string>& kept) {
  std::string text;
  for (const std::string& name : kept) text += state_of(earlier / name) + " " + name + "\n";
  for (const std::string& name : files_below(folder)) {
    if (is_plain(name)) text += state_of(folder / name) + " " + name + "\n";
  }
  OutputFile file(folder / list_name(owner), Appears::when_renamed);
  file.write(text);
  file.finish();
}

std::vector<std::string> unchanged_results(const fs::path& folder, const std::string& owner) {
  std::vector<std::string> names;
  std::error_code none;
  const fs::path list = folder / list_name(owner);
  if (!fs::is_regular_file(list, none)) return names;  // nor a pipe
  std::ifstream file(list, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    std::string size, time, name;
    fields >> size >> time;
    fields.get();
    std::getline(fields, name);
    const bool leads_out = name.empty() || name.front() == '/' || name.find("..") == 0 ||
                           name.find("/..") != std::string::npos;
    if (!leads_out && state_of(folder / name) == size.append(" ").append(time))
      names.push_back(name);
  }
  names.push_back(list_name(owner));
  return names;
}

}  // namespace marco::files
