#pragma once

#include <string>

namespace marco::process {

/// "0.1.0 (a2c5eb6d41)": the project's version and the commit that the program was linked at. The
/// version alone where the project was no clone, and in a program that uses an installed Marco.
std::string version();

}  // namespace marco::process
