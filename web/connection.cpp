#include "web/connection.hpp"

#include "web/http_connection.hpp"

namespace marco::web {

std::string address_of(const Tcp::socket& socket) {
  error_code error;
  const asio::ip::address address = socket.remote_endpoint(error).address();
  if (address.is_v4()) return address.to_string();
  const asio::ip::address_v6 six = address.to_v6();
  if (six.is_v4_mapped()) return asio::ip::make_address_v4(asio::ip::v4_mapped, six).to_string();
  auto bytes = six.to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), 0);
  return asio::ip::address_v6(bytes).to_string();
}

void start_connection(Tcp::socket socket, Shared& shared, Tls* tls) {
  std::make_shared<HttpConnection>(ByteStream(std::move(socket), tls), shared)->start();
}

}  // namespace marco::web
