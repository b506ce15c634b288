#include "tools/many/recording_list.hpp"

#include <algorithm>
#include <fstream>
#include <set>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "recordings/recording.hpp"

namespace marco::many {
namespace {

namespace fs = std::filesystem;

// A folder is one recording or a folder of them; hidden files, and results of ours, are neither.
void collect(const fs::path& folder, std::vector<fs::path>& found) {
  if (fs::exists(folder / "report.json")) return;
  std::vector<fs::path> inside;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.path().filename().string().starts_with('.')) inside.push_back(entry.path());
  }
  std::sort(inside.begin(), inside.end());
  for (const fs::path& path : inside) {
    if (is_recording(path)) {
      found.push_back(path);
    } else if (fs::is_directory(path)) {
      collect(path, found);
    }
  }
}

std::vector<fs::path> listed(const fs::path& list) {
  std::vector<fs::path> found;
  std::ifstream file(list);
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const fs::path path = fs::path(line).is_absolute() ? fs::path(line) : list.parent_path() / line;
    require(fs::exists(path), list.string() + ": there is no " + path.string());
    found.push_back(path);
  }
  return found;
}

// What can be a folder's name, and a word of a shell.
std::string plain_name(const fs::path& path) {
  std::string name = path.stem().string();
  if (name.ends_with(".mcap") || name.ends_with(".db3")) name.resize(name.rfind('.'));
  for (char& letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) == 0 && letter != '-' && letter != '.') letter = '_';
  }
  if (name.empty() || name.front() == '.') name = "log" + name;
  return name == "jobs" ? "jobs_log" : name;
}

}  // namespace

std::vector<fs::path> find_recordings(const fs::path& argument) {
  require(fs::exists(argument), argument.string() + ": is not there");
  std::vector<fs::path> found;
  if (is_recording(argument)) {
    found = {argument};
  } else if (fs::is_directory(argument)) {
    collect(argument, found);
  } else {
    found = listed(argument);
  }
  require(!found.empty(), argument.string() + ": no recording in it, nor a list of some");
  for (fs::path& path : found) path = fs::canonical(path);
  return found;
}

std::vector<Entry> with_names(std::vector<Entry> earlier, const std::vector<fs::path>& recordings) {
  std::set<std::string> names;
  std::set<fs::path> paths;
  for (const Entry& entry : earlier) {
    names.insert(entry.name);
    paths.insert(entry.path);
  }
  for (const fs::path& path : recordings) {
    if (!paths.insert(path).second) continue;
    const std::string plain = plain_name(path);
    std::string name = plain;
    for (int i = 2; !names.insert(name).second; ++i) name = plain + "_" + std::to_string(i);
    earlier.push_back({name, path});
  }
  return earlier;
}

std::vector<Entry> read_list(const fs::path& file) {
  std::vector<Entry> entries;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t tab = line.find('\t');
    if (tab != std::string::npos) entries.push_back({line.substr(0, tab), line.substr(tab + 1)});
  }
  return entries;
}

void write_list(const fs::path& file, const std::vector<Entry>& entries) {
  std::string text;
  for (const Entry& entry : entries) text += entry.name + "\t" + entry.path.string() + "\n";
  files::write_whole_file(file, text);
}

}  // namespace marco::many
