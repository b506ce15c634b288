#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace marco::web {

/// Who may look, and who may steer. Pure: decides by the headers of a request.
///
/// A page of another site that is open in a user's browser must not reach the robot. So `Host` must
/// be an address or a name of this host (a site that has its own name point here is refused), and
/// `Origin`, which browsers send and pages cannot forge, must be this server or be listed. On
/// loopback the app of Foxglove may look; it steers where it is listed or has the token.
class Access {
 public:
  enum class Right { refused, look, steer };
  static constexpr const char* kWrongToken = "refused: a wrong token";  ///< a cause of refusal
  struct Request {
    std::string_view host, origin;  ///< headers; "" = absent
    std::string_view token;
  };

  /// @param token  "" = nobody needs one, which is for loopback
  /// @param origins  of others' pages that are let in, as browsers send them: "https://app.x.org"
  /// @param names  of this host
  Access(std::string token,
         bool is_loopback,
         std::vector<std::string> origins,
         std::vector<std::string> names);

  /// Of a WebSocket. @param why  gets the cause of a refusal
  Right judge(const Request& request, std::string& why) const;
  /// Whether `Host` is ours, which plain files need as well.
  bool is_our_host(std::string_view host) const;

 private:
  bool is_ours(const Request& request) const;
  bool is_listed(std::string_view origin) const;

  std::string token_;
  bool is_loopback_;
  std::vector<std::string> origins_, names_;
};

/// Takes the same time wherever the texts differ.
bool are_equal(std::string_view given, std::string_view secret);

/// 128 random bits in letters, digits, `-` and `_`.
std::string new_token();

/// What makes a token easy to guess, or unfit for an address, as words after "the token"; "" =
/// nothing. Good ones have 16 characters and more, 8 of them different.
std::string why_weak(std::string_view token);

/// Whether `address` is one of this host's own, 127/8 or ::1.
bool is_loopback(const std::string& address);

}  // namespace marco::web
