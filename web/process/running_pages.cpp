#include "web/process/running_pages.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/state_folder.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "web/process/token_file.hpp"

#if MARCO_HAS_QRENCODE
#include <langinfo.h>
#include <qrencode.h>

#include <clocale>
#include <memory>
#endif

namespace marco::web {
namespace {

namespace fs = std::filesystem;

/// A home folder may be shared by hosts.
std::string host_mark() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return process::file_name_of(name.data()) + ":";
}

/// Nothing: the page that wrote it is gone.
std::optional<RunningPage> read_entry(const fs::path& path) {
  const procman::Descriptor file(
      open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (!file.is_open()) return std::nullopt;
  if (flock(file.get(), LOCK_SH | LOCK_NB) == 0) {
    unlink(path.c_str());
    return std::nullopt;
  }
  std::array<char, 8192> text{};
  const ssize_t size = pread(file.get(), text.data(), text.size(), 0);
  std::istringstream lines(
      std::string(text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))));
  RunningPage page;
  std::getline(lines, page.url);
  std::getline(lines, page.token_file);
  return page.url.empty() ? std::nullopt : std::optional(page);
}

/// "10.0.0.2", "[fd00::2]"; "" of an address that others do not reach.
std::string reached_at(const ifaddrs& one) {
  const bool is_up = (one.ifa_flags & IFF_UP) != 0 && (one.ifa_flags & IFF_LOOPBACK) == 0;
  if (!is_up || one.ifa_addr == nullptr) return "";
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (one.ifa_addr->sa_family == AF_INET) {
    const auto& four = reinterpret_cast<const sockaddr_in*>(one.ifa_addr)->sin_addr;
    constexpr uint32_t kLinkLocal = 0xA9FE;  // 169.254: nobody gave it an address
    if (ntohl(four.s_addr) >> 16U == kLinkLocal) return "";
    return inet_ntop(AF_INET, &four, text.data(), text.size());
  }
  if (one.ifa_addr->sa_family != AF_INET6) return "";
  const auto& six = reinterpret_cast<const sockaddr_in6*>(one.ifa_addr)->sin6_addr;
  if (IN6_IS_ADDR_LINKLOCAL(&six)) return "";  // needs a scope, which no browser takes
  return std::string("[") + inet_ntop(AF_INET6, &six, text.data(), text.size()) + "]";
}

/// Those of IPv4 first. @param with_ipv6  whether the server listens there, too
std::vector<std::string> hosts(bool with_ipv6) {
  std::vector<std::string> found;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return found;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    const std::string host = reached_at(*one);
    if (!host.empty() && (with_ipv6 || host[0] != '[')) found.push_back(host);
  }
  freeifaddrs(all);
  std::stable_partition(found.begin(), found.end(),
                        [](const std::string& host) { return host[0] != '['; });
  return found;
}

// A text as a QR code for a terminal of UTF-8, dark on white whatever its colours; "" on others,
// for a text that is too long, and where libqrencode was not there when this was built.
#if MARCO_HAS_QRENCODE
std::string qr_code(const std::string& text) {
  constexpr int kQuiet = 4;  // modules around it, of the standard
  setlocale(LC_CTYPE, "");
  if (std::string_view(nl_langinfo(CODESET)) != "UTF-8") return "";
  const std::unique_ptr<QRcode, void (*)(QRcode*)> code(
      QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_L), QRcode_free);
  if (code == nullptr) return "";
  const auto is_dark = [&](int x, int y) {
    const int size = code->width;
    return x >= 0 && y >= 0 && x < size && y < size && (code->data[y * size + x] & 1) != 0;
  };
  std::string drawn;
  for (int y = -kQuiet; y < code->width + kQuiet; y += 2) {
    drawn += "\x1b[30;107m";  // black on white
    for (int x = -kQuiet; x < code->width + kQuiet; ++x) {
      const bool upper = is_dark(x, y), lower = is_dark(x, y + 1);
      drawn += upper ? (lower ? "█" : "▀") : (lower ? "▄" : " ");
    }
    drawn += "\x1b[0m\n";
  }
  return drawn;
}
#else
std::string qr_code(const std::string& /*text*/) { return ""; }
#endif

}  // namespace

PageEntry::PageEntry(const RunningPage& page)
    : path_((page_folder() / (host_mark() + std::to_string(getpid()))).string()) {
  // Under another name until it is locked: an entry without a lock is removed by who reads it.
  const std::string part = (page_folder() / ("new-" + std::to_string(getpid()))).string();
  unlink(part.c_str());
  file_.reset(open(part.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  const std::string text = page.url + "\n" + page.token_file + "\n";
  if (!file_.is_open() || flock(file_.get(), LOCK_EX | LOCK_NB) != 0 ||
      write(file_.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      rename(part.c_str(), path_.c_str()) != 0) {
    procman::throw_errno("cannot write " + path_);
  }
}

PageEntry::~PageEntry() { unlink(path_.c_str()); }

std::vector<RunningPage> running_pages() {
  std::vector<RunningPage> pages;
  for (const auto& entry : fs::directory_iterator(page_folder())) {
    if (!entry.path().filename().string().starts_with(host_mark())) continue;
    if (auto page = read_entry(entry.path())) pages.push_back(std::move(*page));
  }
  return pages;
}

std::vector<std::string> addresses_of(const std::string& url, const std::string& token) {
  const std::string query = token.empty() ? "" : "?token=" + token;
  for (const std::string any : {"//0.0.0.0:", "//[::]:"}) {
    const std::size_t at = url.find(any);
    if (at == std::string::npos) continue;
    std::vector<std::string> all;
    for (const std::string& host : hosts(any[2] == '[')) {
      all.push_back(url.substr(0, at + 2) + host + url.substr(at + any.size() - 1) + query);
    }
    if (!all.empty()) return all;
    return {url.substr(0, at + 2) + "localhost" + url.substr(at + any.size() - 1) + query};
  }
  return {url + query};
}

bool is_seen_by_user_only() {
  termios modes = {};
  return tcgetattr(STDOUT_FILENO, &modes) == 0 &&
         (modes.c_lflag & static_cast<tcflag_t>(ECHO)) != 0;
}

int print_addresses() {
  const std::vector<RunningPage> pages = running_pages();
  if (pages.empty()) {
    std::fputs("no page of this user is running on this host\n", stderr);
    return process::kExitFailed;
  }
  const bool is_safe = is_seen_by_user_only();
  for (const RunningPage& page : pages) {
    const bool has_token = !page.token_file.empty();
    const std::string token = has_token && is_safe ? token_in(page.token_file) : "";
    for (const std::string& address : addresses_of(page.url, token)) {
      std::printf("%s\n", address.c_str());
      if (is_safe && has_token) std::fputs(qr_code(address).c_str(), stdout);
    }
    if (has_token && !is_safe) {
      std::fprintf(stderr, "its token is printed on a terminal only; it is in %s\n",
                   page.token_file.c_str());
    }
  }
  return process::kExitDone;
}

}  // namespace marco::web
