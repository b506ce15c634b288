#pragma once

#include <string>

namespace marco::process {

/// "0.1.0 (a2c5eb6d41)": the version of the project and the commit at link time. The version alone
/// without a git clone, and in programs that use an installed package.
std::string version();

}  // namespace marco::process
