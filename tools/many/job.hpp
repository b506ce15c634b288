#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/many/recording_list.hpp"

namespace marco::many {

/// The results of many recordings: OUT/NAME of each, as marco-map writes it, and OUT/jobs with the
/// list of recordings, what each run printed (NAME.log), why one failed (NAME.json) and a journal.
struct Store {
  std::filesystem::path out;

  std::filesystem::path jobs() const { return out / "jobs"; }
  std::filesystem::path list() const { return jobs() / "list.tsv"; }
  std::filesystem::path results(const Entry& entry) const { return out / entry.name; }
  std::filesystem::path report(const Entry& entry) const { return results(entry) / "report.json"; }
  std::filesystem::path failure(const Entry& entry) const {
    return jobs() / (entry.name + ".json");
  }
  std::filesystem::path printed(const Entry& entry) const { return jobs() / (entry.name + ".log"); }
  std::filesystem::path lock(const Entry& entry) const { return jobs() / (entry.name + ".lock"); }
  std::filesystem::path journal() const { return jobs() / "journal.csv"; }
};

/// Whether there is nothing left to do: a map was made, or it is known why there can be none.
bool is_done(const Store& store, const Entry& entry);

enum class JobEnd {
  done,    ///< now or before
  failed,  ///< recorded, and not tried again
  killed   ///< nothing recorded: to be tried again
};

/// Maps one recording, unless that is done; waits where somebody else does it now. Whoever is
/// killed meanwhile leaves nothing behind: a lock ends with its process, results appear as a whole.
/// @param arguments  more of marco-map's
/// @throws std::runtime_error where no program can be started
JobEnd run_job(const Store& store, const Entry& entry, const std::vector<std::string>& arguments);

/// Records that a recording is given up.
void record_failure(const Store& store,
                    const Entry& entry,
                    const std::string& message,
                    double cpu_s);

}  // namespace marco::many
