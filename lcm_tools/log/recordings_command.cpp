#include <algorithm>
#include <filesystem>

#include "lcm_tools/base/amounts.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/log/commands.hpp"
#include "lcm_tools/recorder/recordings.hpp"

namespace marco::logs {
namespace {

std::string length_text(const std::filesystem::path& recording) {
  const auto seconds = recorder::length_s(recording);
  return seconds ? span_text(*seconds) : "empty";
}

std::string remark_on(const recorder::Recording& recording) {
  if (!recording.running) return recording.kept;
  return recording.kept.empty() ? "running" : "running, " + recording.kept;
}

}  // namespace

void run_recordings(const RecordingsArguments& arguments) {
  const std::filesystem::path home =
      arguments.home.empty() ? recorder::default_home() : std::filesystem::path(arguments.home);
  const std::vector<recorder::Recording> all = recorder::recordings_in(home);
  require(!all.empty(), "no recording of marco-recorder in " + home.string());
  std::size_t width = 0;
  for (const auto& one : all) width = std::max(width, one.folder.filename().string().size());
  int64_t bytes = 0;
  for (const recorder::Recording& one : all) {
    bytes += one.bytes;
    print(stdout, "%-*s  %10s  %10s  %s\n", static_cast<int>(width), one.folder.filename().c_str(),
          length_text(one.folder).c_str(), size_text(static_cast<double>(one.bytes)).c_str(),
          remark_on(one).c_str());
  }
  print(stdout, "%zu recordings, %s, in %s\n", all.size(),
        size_text(static_cast<double>(bytes)).c_str(), home.c_str());
}

void run_keep(const KeepArguments& arguments) {
  for (const std::string& given : arguments.recordings) {
    const std::filesystem::path in_home = recorder::default_home() / given;
    const bool is_folder = std::filesystem::is_directory(given);
    const std::filesystem::path folder = is_folder ? std::filesystem::path(given) : in_home;
    recorder::keep(folder,
                   arguments.undo ? recorder::Keep::until_room_is_needed : recorder::Keep::forever);
    print(stdout, "%s %s\n", folder.c_str(),
          arguments.undo ? "may be deleted to make room" : "is kept");
  }
}

}  // namespace marco::logs
