#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lcm_tools/process/arguments.hpp"
#include "web/access.hpp"
#include "web/server.hpp"
#include "web/site.hpp"

namespace marco::web {

struct PageArguments {
  process::CommonArguments common;
  std::string shown;  ///< a map folder or a recording; "" = what is live
  std::string listen;
  std::string token_file, given_token;
  bool wants_address = false;
  std::vector<std::string> origins;
  std::string certificate, key;
  double speed = 1.0;  ///< of a recording
};

void add_page_arguments(process::CommandLine& app, PageArguments& arguments);

/// ADDRESS[:PORT] of --listen. @throws process::UsageError for another form.
ServerOptions server_options(const PageArguments& arguments);

/// Where the token in force stands; "" = none is needed.
std::string token_file_of(const PageArguments& arguments, const ServerOptions& options);

Access access_of(const PageArguments& arguments,
                 const ServerOptions& options,
                 const std::string& token);

}  // namespace marco::web
