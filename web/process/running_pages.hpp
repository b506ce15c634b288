#pragma once

#include <string>
#include <vector>

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::web {

/// How a page is reached.
struct RunningPage {
  std::string url;         ///< of the server; its host may be 0.0.0.0
  std::string token_file;  ///< "" = it needs no token
};

/// Says, for as long as it lives, that a page of this user runs on this host. One that was killed
/// is known by its lock, which nobody holds.
class PageEntry {
 public:
  /// @throws std::runtime_error where it cannot be written
  explicit PageEntry(const RunningPage& page);
  ~PageEntry();
  PageEntry(const PageEntry&) = delete;
  PageEntry& operator=(const PageEntry&) = delete;

 private:
  std::string path_;
  procman::Descriptor file_;
};

/// The pages of this user on this host.
std::vector<RunningPage> running_pages();

/// The addresses at which a browser finds a server: where it listens to all, those of this host
/// that others reach. @param token  "" = without
std::vector<std::string> addresses_of(const std::string& url, const std::string& token);

/// Whether standard output is a terminal of a person, who sees what is typed there. Procman's
/// commands have a terminal, too, whose text goes to everybody who watches.
bool is_seen_by_user_only();

/// Prints the address of each running page, and on a user's terminal the token in it and a QR code.
/// @returns the exit code
int print_addresses();

}  // namespace marco::web
