#include "tools/many/job.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "tools/many/child.hpp"

namespace marco::many {
namespace {

namespace fs = std::filesystem;

// Waits for it. Held while this lives; the system lets go of it when the process ends, however it
// does.
class Lock {
 public:
  explicit Lock(const fs::path& path)
      // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg)
      : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)),
        is_held_(descriptor_ >= 0 && flock(descriptor_, LOCK_EX) == 0) {}
  ~Lock() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
  bool is_held() const { return is_held_; }

 private:
  int descriptor_;
  bool is_held_;
};

// One write a line: lines of several processes do not mix.
void note(const Store& store, const Entry& entry, const std::string& what) {
  std::FILE* file = std::fopen(store.journal().c_str(), "a");
  if (file == nullptr) return;
  std::fprintf(file, "%.3f,%s,%s\n", 1e-6 * static_cast<double>(process::wall_clock_us()),
               entry.name.c_str(), what.c_str());
  std::fclose(file);
}

// What a program said last: why it failed.
std::string last_line(const fs::path& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    const std::size_t shown = line.rfind('\r');  // a progress line writes over itself
    if (shown != std::string::npos) line.erase(0, shown + 1);
    if (!line.empty()) last = line;
  }
  return last;
}

bool is_crash(int signal) {
  return signal == SIGSEGV || signal == SIGABRT || signal == SIGBUS || signal == SIGFPE ||
         signal == SIGILL;
}

bool was_killed(const ChildEnd& end) {
  return end.pid < 0 || (end.signal != 0 && !is_crash(end.signal)) ||
         end.exit_code > process::kExitSignal;
}

// Maps it once. @returns nothing where the results are there
std::optional<ChildEnd> try_once(const Store& store,
                                 const Entry& entry,
                                 const std::vector<std::string>& arguments) {
  std::error_code ignored;
  fs::remove(store.printed(entry), ignored);
  std::vector<std::string> words(entry.parts.begin(), entry.parts.end());
  words.insert(words.end(), {"--out", store.results(entry).string()});
  words.insert(words.end(), arguments.begin(), arguments.end());
  const ChildEnd end = wait_for_child(
      start_child(sibling_path("marco-map"), std::move(words), store.printed(entry)));
  if (fs::exists(store.report(entry))) return std::nullopt;
  return end;
}

}  // namespace

bool is_done(const Store& store, const Entry& entry) {
  return fs::exists(store.report(entry)) || fs::exists(store.failure(entry));
}

void record_failure(const Store& store,
                    const Entry& entry,
                    const std::string& message,
                    double cpu_s) {
  const nlohmann::json record = {{"message", message}, {"cpu_s", cpu_s}};
  files::write_whole_file(
      store.failure(entry),
      record.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  note(store, entry, "failed");
}

JobEnd run_job(const Store& store, const Entry& entry, const std::vector<std::string>& arguments) {
  const Lock lock(store.lock(entry));
  require(lock.is_held(), store.lock(entry).string() + ": cannot be locked");
  if (fs::exists(store.report(entry))) return JobEnd::done;
  if (is_done(store, entry)) return JobEnd::failed;
  note(store, entry, "begun");
  auto failed = try_once(store, entry, arguments);
  // A program that marco-map started may have been killed: what fails twice fails always.
  if (failed && !was_killed(*failed)) failed = try_once(store, entry, arguments);
  if (!failed) {
    note(store, entry, "done");
    return JobEnd::done;
  }
  if (was_killed(*failed)) {
    note(store, entry, "killed");
    return JobEnd::killed;
  }
  record_failure(store, entry,
                 failed->signal != 0 ? "crashed: signal " + std::to_string(failed->signal)
                                     : last_line(store.printed(entry)),
                 failed->cpu_s);
  return JobEnd::failed;
}

}  // namespace marco::many
