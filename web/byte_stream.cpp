#include "web/byte_stream.hpp"

#include <boost/asio/ssl.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <stdexcept>

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

struct ByteStream::Plain : Transport {
  explicit Plain(Tcp::socket socket) : stream(std::move(socket)) {}
  beast::tcp_stream& tcp() override { return stream; }
  void handshake(Done done) override { done({}); }
  void read(asio::mutable_buffer into, Moved moved) override {
    stream.async_read_some(into, std::move(moved));
  }
  void write(const Parts& parts, Moved moved) override {
    stream.async_write_some(parts, std::move(moved));
  }
  void teardown(Done done) override {
    beast::websocket::async_teardown(beast::role_type::server, stream.socket(), std::move(done));
  }
  beast::tcp_stream stream;
};

struct ByteStream::Secured : Transport {
  Secured(Tcp::socket socket, Tls& tls) : stream(std::move(socket), tls.context()) {}
  beast::tcp_stream& tcp() override { return stream.next_layer(); }
  void handshake(Done done) override {
    stream.async_handshake(asio::ssl::stream_base::server, std::move(done));
  }
  void read(asio::mutable_buffer into, Moved moved) override {
    stream.async_read_some(into, std::move(moved));
  }
  void write(const Parts& parts, Moved moved) override {
    stream.async_write_some(parts, std::move(moved));
  }
  void teardown(Done done) override { stream.async_shutdown(std::move(done)); }
  beast::ssl_stream<beast::tcp_stream> stream;
};

ByteStream::ByteStream(Tcp::socket socket, Tls* tls) {
  if (tls == nullptr) {
    transport_ = std::make_unique<Plain>(std::move(socket));
  } else {
    transport_ = std::make_unique<Secured>(std::move(socket), *tls);
  }
}

}  // namespace marco::web
