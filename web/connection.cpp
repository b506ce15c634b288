#include "web/connection.hpp"

#include <boost/asio/ssl.hpp>
#include <boost/beast/ssl.hpp>
#include <stdexcept>

#include "web/http_connection.hpp"

namespace marco::web {

struct Tls::Context : asio::ssl::context {
  Context() : asio::ssl::context(asio::ssl::context::tls_server) {}
};

Tls::Tls(const std::string& certificate, const std::string& key)
    : context_(std::make_unique<Context>()) {
  try {
    context_->set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                          asio::ssl::context::no_tlsv1_1);
    context_->use_certificate_chain_file(certificate);
    context_->use_private_key_file(key, asio::ssl::context::pem);
  } catch (const boost::system::system_error& failure) {
    throw std::runtime_error("the certificate " + certificate + " with the key " + key +
                             " cannot be used: " + failure.code().message());
  }
}

Tls::~Tls() = default;

void start_connection(Tcp::socket socket, Shared& shared, Tls* tls) {
  beast::tcp_stream tcp(std::move(socket));
  if (tls == nullptr) {
    std::make_shared<HttpConnection<beast::tcp_stream>>(std::move(tcp), shared)->start();
    return;
  }
  using Secured = beast::ssl_stream<beast::tcp_stream>;
  std::make_shared<HttpConnection<Secured>>(Secured(std::move(tcp), tls->context()), shared)
      ->start();
}

}  // namespace marco::web
