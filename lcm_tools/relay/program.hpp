#pragma once

#include <string>
#include <vector>

namespace marco::relay {

/// The command line of marco-relay.
/// @param order_channels  of the robots it is for, besides procman's
int run_relay_program(int argc, char** argv, std::vector<std::string> order_channels);

}  // namespace marco::relay
