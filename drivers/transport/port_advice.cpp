#include "drivers/transport/port_advice.hpp"

#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>

#include "lcm_tools/diagnosis/host.hpp"

namespace marco::drivers {
namespace {

namespace fs = std::filesystem;

struct KindNames {
  const char* plural;
  const char* by_id_folder;
  std::vector<std::string> prefixes;
};

const KindNames& names_of(DeviceKind kind) {
  static const std::map<DeviceKind, KindNames> kNames{
      {DeviceKind::serial,
       {"serial ports", "serial/by-id", {"ttyUSB", "ttyACM", "ttyAMA", "rfcomm"}}},
      {DeviceKind::gamepad, {"gamepads", "input/by-id", {"input/js"}}},
      {DeviceKind::camera, {"cameras", "v4l/by-id", {"video"}}}};
  return kNames.at(kind);
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    entries.push_back(entry->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

std::string group_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return {};
  const group* found = ::getgrgid(status.st_gid);
  return found == nullptr ? std::to_string(status.st_gid) : found->gr_name;
}

std::string seen_text(const OpenFailure& failure) {
  const std::string plural = names_of(failure.kind).plural;
  if (failure.seen.empty()) {
    return "no such device, and no " + plural +
           " are plugged in: are cable and power right? `dmesg` shows what was plugged in";
  }
  std::string text = "no such device; " + plural + " here: ";
  for (const DeviceSeen& device : failure.seen) {
    if (&device != &failure.seen.front()) text += ", ";
    text += device.by_id.empty() ? device.path : device.path + " (" + device.by_id + ")";
  }
  return text + ". Give one with --device";
}

std::string permission_text(const OpenFailure& failure) {
  if (failure.group.empty() || failure.group == "root") {
    return "permission denied: only root may open it; a udev rule can give it to a group";
  }
  return "permission denied: it belongs to the group " + failure.group +
         ". Add yourself: `sudo usermod -aG " + failure.group + " $USER`, then log in again";
}

}  // namespace

std::vector<DeviceSeen> devices_seen(DeviceKind kind, const std::string& folder) {
  const KindNames& names = names_of(kind);
  std::vector<DeviceSeen> seen;
  for (const std::string& prefix : names.prefixes) {
    const fs::path start = fs::path(folder) / prefix;
    for (const fs::path& entry : entries_of(start.parent_path())) {
      const bool fits = entry.filename().string().starts_with(start.filename().string());
      if (fits) seen.push_back({entry.string(), ""});
    }
  }
  for (const fs::path& link : entries_of(fs::path(folder) / names.by_id_folder)) {
    std::error_code error;
    const fs::path target = fs::weakly_canonical(link, error);
    for (DeviceSeen& device : seen) {
      if (fs::weakly_canonical(device.path, error) == target) device.by_id = link.string();
    }
  }
  return seen;
}

std::string open_failure_text(const OpenFailure& failure) {
  std::string why = std::strerror(failure.error);
  if (failure.error == EACCES || failure.error == EPERM) why = permission_text(failure);
  if (failure.error == EBUSY || failure.error == EWOULDBLOCK) {
    why = "held by " + (failure.holder.empty() ? "another process" : failure.holder);
  }
  if (failure.error == ENOENT || failure.error == ENODEV || failure.error == ENXIO) {
    // Outside of /dev are the emulators' links.
    why = failure.path.starts_with("/dev/")
              ? seen_text(failure)
              : "no such device: is the program that creates it (marco-sim) running?";
  }
  return failure.path + ": " + why;
}

std::string why_not_open(const std::string& path, int error, DeviceKind kind) {
  return open_failure_text(
      {path, error, kind, devices_seen(kind), group_of(path), holder_of(path)});
}

std::string holder_of(const std::string& path) {
  std::error_code error;
  const fs::path device = fs::canonical(path, error);
  if (error) return {};
  for (const int pid : diagnosis::running_pids()) {
    if (pid == ::getpid()) continue;
    for (const fs::path& open : entries_of("/proc/" + std::to_string(pid) + "/fd")) {
      if (fs::read_symlink(open, error) == device && !error) {
        return diagnosis::command_name(pid) + " (" + std::to_string(pid) + ")";
      }
    }
  }
  return {};
}

}  // namespace marco::drivers
