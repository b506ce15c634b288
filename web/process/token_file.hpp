#pragma once

#include <filesystem>
#include <string>

namespace marco::web {

/// The token that a file of this user holds, which nobody else can read. A file that is not there
/// is made, with a new token.
/// @throws std::runtime_error saying what is wrong: others can read it, it is no regular file of
/// this user, its token is weak, it cannot be made. No message has the token.
std::string token_in(const std::filesystem::path& file);

/// Where pages keep what is this user's alone: the token, and how each of them is reached. Made,
/// with mode 700, where it is not there. @throws std::runtime_error where that cannot be, or it is
/// another user's.
std::filesystem::path page_folder();

}  // namespace marco::web
