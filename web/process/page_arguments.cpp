#include "web/process/page_arguments.hpp"

#include <unistd.h>

#include <array>
#include <charconv>

#include "lcm_tools/process/exit_code.hpp"
#include "web/process/token_file.hpp"

namespace marco::web {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace

void add_page_arguments(process::CommandLine& app, PageArguments& arguments) {
  process::add_common_arguments(app, arguments.common);
  app.add_option("SHOWN", arguments.shown,
                 "a map folder or a recording; default: live data on LCM");
  app.add_option(
      "--listen", arguments.listen,
      "ADDRESS[:PORT] to listen on, default 127.0.0.1:8765; other hosts need a token to steer");
  app.add_option(
      "--token-file", arguments.token_file,
      "clients with the token in this file may steer; the file is created if it does not exist; "
      "default: none for this host alone, otherwise one in your state folder");
  app.add_option("--token", arguments.given_token, "refused: others would see it")
      .check([](const std::string&) {
        return "others can see a token in a command line; write it into a file of mode 600, and "
               "pass that with --token-file FILE";
      });
  app.add_flag("--address", arguments.wants_address,
               "print the addresses of your pages running here, with their tokens, and exit");
  app.add_option(
      "--origin", arguments.origins,
      "another site whose pages may use this server, e.g. https://app.foxglove.dev; repeatable");
  auto certificate =
      app.add_option("--certificate", arguments.certificate, "PEM file: https instead of http")
          .existing_file();
  auto key = app.add_option("--key", arguments.key, "PEM file of the certificate's key")
                 .existing_file()
                 .needs(certificate);
  certificate.needs(key);
  app.add_option("--speed", arguments.speed, "of a recording; 1 = real time")
      .between(0.01, 1000.0)
      .shows_default();
}

ServerOptions server_options(const PageArguments& arguments) {
  ServerOptions options;
  options.certificate = arguments.certificate;
  options.key = arguments.key;
  if (arguments.listen.empty()) return options;
  std::string address = arguments.listen, port;
  const std::size_t bracket = address.find(']');  // of an IPv6 address
  const std::size_t colon = address.find(':', bracket == std::string::npos ? 0 : bracket);
  const bool is_bare_ipv6 = bracket == std::string::npos && address.find(':') != address.rfind(':');
  if (colon != std::string::npos && !is_bare_ipv6) {
    port = address.substr(colon + 1);
    address.resize(colon);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), options.port);
    if (error != std::errc() || end != port.data() + port.size()) address.clear();
  }
  if (address.starts_with('[')) address = address.substr(1, address.find(']') - 1);
  if (address == "localhost") address = "127.0.0.1";
  process::require_usage(!address.empty(), "--listen takes ADDRESS[:PORT], e.g. 0.0.0.0:8765");
  options.address = address;
  return options;
}

std::string token_file_of(const PageArguments& arguments, const ServerOptions& options) {
  if (!arguments.token_file.empty())
    return std::filesystem::absolute(arguments.token_file).string();
  return is_loopback(options.address) ? "" : (page_folder() / "token").string();
}

Access access_of(const PageArguments& arguments,
                 const ServerOptions& options,
                 const std::string& token) {
  std::vector<std::string> names = {host_name(), host_name() + ".local"};
  for (const std::string& origin : arguments.origins) {
    process::require_usage(origin.find("://") != std::string::npos,
                           "--origin takes a scheme and a host, e.g. https://app.foxglove.dev");
  }
  return Access(token, is_loopback(options.address), arguments.origins, std::move(names));
}

}  // namespace marco::web
