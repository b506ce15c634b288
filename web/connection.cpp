#include "web/connection.hpp"

#include "web/http_connection.hpp"

namespace marco::web {

void start_connection(Tcp::socket socket, Shared& shared, Tls* tls) {
  std::make_shared<HttpConnection>(ByteStream(std::move(socket), tls), shared)->start();
}

}  // namespace marco::web
