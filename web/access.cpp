#include "web/access.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <random>
#include <regex>
#include <set>

namespace marco::web {
namespace {

constexpr std::string_view kFoxglove = "https://app.foxglove.dev";

std::string lower(std::string_view text) {
  std::string copy(text);
  std::transform(copy.begin(), copy.end(), copy.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return copy;
}

/// "robot", of "robot:8765"; "::1", of "[::1]:8765"; "" of what is no name with a port.
std::string name_of(std::string_view host) {
  static const std::regex kForm(R"((?:\[([^\]]+)\]|([^\[\]:]+))(?::[0-9]*)?)");
  constexpr std::size_t kLongest = 300;  // std::regex takes stack for each letter
  std::cmatch found;
  if (host.size() > kLongest || !std::regex_match(host.begin(), host.end(), found, kForm))
    return "";
  return lower(found[found[1].matched ? 1 : 2].str());
}

bool is_address(const std::string& name) {
  std::array<unsigned char, 16> bytes;
  return inet_pton(AF_INET, name.c_str(), bytes.data()) == 1 ||
         inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1;
}

}  // namespace

bool are_equal(std::string_view given, std::string_view secret) {
  std::size_t difference = given.size() ^ secret.size();
  for (std::size_t i = 0; i < secret.size(); ++i) {
    const char c = given.empty() ? '\0' : given[i % given.size()];
    difference |= static_cast<std::size_t>(static_cast<unsigned char>(c ^ secret[i]));
  }
  return difference == 0;
}

std::string new_token() {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  std::random_device device;  // the kernel's
  std::string token;
  for (int i = 0; i < 22; ++i) token += kDigits[device() % kDigits.size()];
  return token;
}

std::string why_weak(std::string_view token) {
  constexpr std::size_t kLeast = 16, kLeastDifferent = 8, kMost = 200;
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; };
  if (!std::all_of(token.begin(), token.end(), fits)) {
    return "has characters other than letters, digits, - and _";
  }
  if (token.size() < kLeast) return "is shorter than 16 characters";
  if (token.size() > kMost) return "is longer than 200 characters";
  const bool is_varied = std::set<char>(token.begin(), token.end()).size() >= kLeastDifferent;
  return is_varied ? "" : "has fewer than 8 different characters";
}

bool is_loopback(const std::string& address) {
  in_addr four = {};
  if (inet_pton(AF_INET, address.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24U == 127;
  in6_addr six = {};
  return inet_pton(AF_INET6, address.c_str(), &six) == 1 && IN6_IS_ADDR_LOOPBACK(&six);
}

Access::Access(std::string token,
               bool is_loopback,
               std::vector<std::string> origins,
               std::vector<std::string> names)
    : token_(std::move(token)),
      is_loopback_(is_loopback),
      origins_(std::move(origins)),
      names_(std::move(names)) {
  for (std::string& origin : origins_) origin = lower(origin);
  for (std::string& name : names_) name = lower(name);
}

bool Access::is_our_host(std::string_view host) const {
  const std::string name = name_of(host);
  // No site can have an address in place of its name.
  return is_address(name) || name == "localhost" ||
         std::find(names_.begin(), names_.end(), name) != names_.end();
}

bool Access::is_ours(const Request& request) const {
  const std::size_t scheme = request.origin.find("://");
  return scheme != std::string_view::npos &&
         lower(request.origin.substr(scheme + 3)) == lower(request.host);
}

bool Access::is_listed(std::string_view origin) const {
  return std::find(origins_.begin(), origins_.end(), lower(origin)) != origins_.end();
}

Access::Right Access::judge(const Request& request, std::string& why) const {
  if (!is_our_host(request.host)) {
    why = "refused: unknown host name";
    return Right::refused;
  }
  const bool has_token = !token_.empty() && are_equal(request.token, token_);
  if (!request.token.empty() && !token_.empty() && !has_token) {
    why = kWrongToken;
    return Right::refused;
  }
  const bool is_trusted = request.origin.empty() || is_ours(request) || is_listed(request.origin);
  if (!is_trusted && !(is_loopback_ && lower(request.origin) == kFoxglove)) {
    why = "refused: a page of another site (--origin allows sites)";
    return Right::refused;
  }
  return has_token || (is_trusted && token_.empty()) ? Right::steer : Right::look;
}

}  // namespace marco::web
