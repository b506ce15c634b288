#include "tests/process/bridge/foxglove_stub.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>

namespace marco::testing {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Tcp = asio::ip::tcp;
using Stream = beast::websocket::stream<beast::tcp_stream>;
using boost::system::error_code;

}  // namespace

struct FoxgloveStub::Impl {
  asio::io_context io;
  Tcp::acceptor acceptor{io, {asio::ip::make_address("127.0.0.1"), 0}};
  std::unique_ptr<Stream> stream;
  beast::flat_buffer in;
  std::deque<Message> received;
  bool reads = false;

  // Runs what is due, until `done` or the time is over.
  template <class Done>
  bool run(double seconds, Done done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!done()) {
      if (std::chrono::steady_clock::now() >= end) return false;
      io.restart();
      io.run_one_for(std::chrono::milliseconds(10));
    }
    return true;
  }
  void read() {
    reads = true;
    stream->async_read(in, [this](error_code error, std::size_t) {
      if (error) {
        reads = false;
        return;
      }
      received.push_back({stream->got_text(), beast::buffers_to_string(in.data())});
      in.consume(in.size());
      read();
    });
  }
};

FoxgloveStub::FoxgloveStub() : impl_(std::make_unique<Impl>()) {}
FoxgloveStub::~FoxgloveStub() { hang_up(); }

int FoxgloveStub::port() const { return impl_->acceptor.local_endpoint().port(); }

std::string FoxgloveStub::accept(const std::string& subprotocol) {
  std::optional<Tcp::socket> socket;
  impl_->acceptor.async_accept([&socket](error_code error, Tcp::socket accepted) {
    if (!error) socket.emplace(std::move(accepted));
  });
  if (!impl_->run(10.0, [&socket] { return socket.has_value(); })) {
    impl_->acceptor.cancel();
    impl_->run(0.1, [] { return false; });
    return "";
  }
  http::request<http::string_body> request;
  beast::flat_buffer buffer;
  http::read(*socket, buffer, request);
  const auto offered = request[http::field::sec_websocket_protocol];
  impl_->stream = std::make_unique<Stream>(std::move(*socket));
  impl_->stream->set_option(beast::websocket::stream_base::decorator(
      [&subprotocol](beast::websocket::response_type& response) {
        response.set(http::field::sec_websocket_protocol, subprotocol);
      }));
  impl_->stream->accept(request);
  impl_->received.clear();
  impl_->read();
  return std::string(offered.data(), offered.size());
}

void FoxgloveStub::hang_up() {
  if (!impl_->stream) return;
  error_code ignored;
  beast::get_lowest_layer(*impl_->stream).socket().close(ignored);
  impl_->run(1.0, [this] { return !impl_->reads; });
  impl_->stream.reset();
  impl_->in.clear();
}

void FoxgloveStub::send_text(const std::string& text) {
  impl_->stream->text(true);
  impl_->stream->write(asio::buffer(text));
}

void FoxgloveStub::send_binary(const std::vector<uint8_t>& message) {
  impl_->stream->binary(true);
  impl_->stream->write(asio::buffer(message));
}

std::optional<FoxgloveStub::Message> FoxgloveStub::receive(double seconds) {
  impl_->run(seconds, [this] { return !impl_->received.empty(); });
  if (impl_->received.empty()) return std::nullopt;
  Message first = std::move(impl_->received.front());
  impl_->received.pop_front();
  return first;
}

}  // namespace marco::testing
