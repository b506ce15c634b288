#include "web/connection.hpp"

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "web/websocket_connection.hpp"

namespace marco::web {
namespace {

constexpr std::chrono::seconds kHeaderWithin{5}, kIdle{5}, kAnswerWithin{60};
constexpr uint32_t kLargestHeader = 16 << 10;

// Answers requests for files, and hands a WebSocket over.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(ByteStream stream, Shared& shared)
      : stream_(std::move(stream)),
        shared_(shared),
        address_(address_of(stream_.tcp().socket())),
        timer_(stream_.get_executor()) {}
  ~HttpConnection() { leave(); }
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  void start() {
    const auto close = [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->end("");
    };
    if (shared_.connections.add(address_, close, place_.emplace())) {
      shared_.drops.count("refused: more than " + std::to_string(Connections::kMost) +
                          " connections");
    }
    stream_.tcp().expires_after(kHeaderWithin);
    stream_.handshake([self = shared_from_this()](error_code error) {
      if (error) return self->end("refused: a TLS handshake that failed");
      self->read(kHeaderWithin);
    });
  }

 private:
  void read(std::chrono::seconds within) {
    parser_.emplace();
    parser_->header_limit(kLargestHeader);
    parser_->body_limit(0);
    stream_.tcp().expires_after(within);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](error_code error, std::size_t) { self->take(error); });
  }

  void take(error_code error) {
    if (error == http::error::end_of_stream) return end("");
    if (error == beast::error::timeout) {
      return end(buffer_.size() > 0 || answered_ == 0 ? "refused: a request that took too long"
                                                      : "");
    }
    if (error) return end("refused: malformed request");
    if (place_) shared_.connections.set_waiting(*place_, false);
    shared_.hub.turns().add(Turns::Rank::requests, [self = shared_from_this()] { self->serve(); });
  }

  void serve() {
    const auto& request = parser_->get();
    if (request.count(http::field::host) > 1) {
      shared_.drops.count("refused: a request with two hosts");
      return answer({400, "text/plain", "Expected one Host header.\n", {}});
    }
    if (!shared_.access.is_our_host(header(http::field::host))) {
      shared_.drops.count("refused: unknown host name");
      return answer({421, "text/plain", "Unknown host name.\n", {}});
    }
    if (websocket::is_upgrade(request)) return upgrade();
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      shared_.drops.count("refused: a method other than GET");
      return answer({405, "text/plain", "GET only.\n", {}});
    }
    answer(shared_.site.get(view(request.target())));
  }

  void upgrade() {
    const auto& request = parser_->get();
    const std::string token = query_value(view(request.target()), "token");
    std::string why;
    const auto right =
        shared_.access.judge({header(http::field::host), header(http::field::origin), token}, why);
    if (right == Access::Right::refused) {
      shared_.drops.count(why);
      return refuse(why);
    }
    const auto offered = header(http::field::sec_websocket_protocol);
    const auto subprotocol = foxglove::choose_subprotocol(offered);
    if (!subprotocol) {
      shared_.drops.count("refused: a subprotocol that is not Foxglove's");
      return answer({400, "text/plain", "foxglove.sdk.v1 or foxglove.websocket.v1\n", {}});
    }
    const Hub::Who who{right == Access::Right::steer, address_};
    if (const std::string full = shared_.hub.why_full(who); !full.empty()) {
      shared_.drops.count(full);
      return answer({503, "text/plain", "Too many clients.\n", {}});
    }
    leave();
    std::make_shared<WebSocketConnection>(std::move(stream_), shared_, who)
        ->start(parser_->release(), *subprotocol);
  }

  // A wrong token is answered late: who guesses tries few.
  void refuse(const std::string& why) {
    const auto later = [self = shared_from_this(), why](error_code cancelled) {
      if (!cancelled && self->place_) self->answer({403, "text/plain", why + "\n", {}});
    };
    if (why != Access::kWrongToken) return later({});
    if (place_) shared_.connections.set_waiting(*place_, true);
    stream_.tcp().expires_never();
    const double wait_s = shared_.guesses.wait_s(address_, steady_s());
    timer_.expires_after(std::chrono::milliseconds(static_cast<int>(1e3 * wait_s)));
    timer_.async_wait(later);
  }

  void answer(const Site::Answer& what) {
    if (!what.file.empty()) {
      http::response<http::file_body> response;
      error_code error;
      response.body().open(what.file.c_str(), beast::file_mode::scan, error);
      if (!error) {
        fill(response, what.status, what.type);
        return send(std::move(response));
      }
    }
    http::response<http::string_body> response;
    const bool is_found = what.file.empty() && what.status != 404;
    fill(response, what.file.empty() ? what.status : 404, is_found ? what.type : "text/plain");
    response.body() = is_found ? what.body : "Not found.\n";
    send(std::move(response));
  }

  template <class Response>
  void fill(Response& response, int status, const std::string& type) const {
    const auto& request = parser_->get();
    response.result(static_cast<unsigned>(status));
    response.version(request.version());
    response.keep_alive(request.keep_alive());
    response.set(http::field::content_type, type);
    response.set(http::field::cache_control, "no-cache");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");  // the address holds the token
    response.set("X-Frame-Options", "DENY");
    response.set("Content-Security-Policy",
                 "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data: blob:; "
                 "style-src 'self' 'unsafe-inline'; frame-ancestors 'none'");
  }

  template <class Body>
  void send(http::response<Body>&& response) {
    auto kept = std::make_shared<http::response<Body>>(std::move(response));
    kept->prepare_payload();
    stream_.tcp().expires_after(kAnswerWithin);
    const auto sent = [self = shared_from_this(), kept](error_code error, std::size_t) {
      if (error || !kept->keep_alive()) return self->end("");
      ++self->answered_;
      if (self->place_) self->shared_.connections.set_waiting(*self->place_, true);
      self->read(kIdle);
    };
    if (parser_->get().method() != http::verb::head) return http::async_write(stream_, *kept, sent);
    auto head = std::make_shared<http::response_serializer<Body>>(*kept);
    http::async_write_header(stream_, *head,
                             [head, sent](error_code error, std::size_t n) { sent(error, n); });
  }

  // @param cause  counted; "" = nothing to count
  void end(const std::string& cause) {
    if (!cause.empty()) shared_.drops.count(cause);
    leave();
    timer_.cancel();
    error_code ignored;
    auto& socket = stream_.tcp().socket();
    socket.shutdown(Tcp::socket::shutdown_both, ignored);
    socket.close(ignored);
  }

  void leave() {
    if (place_) shared_.connections.remove(*std::exchange(place_, std::nullopt));
  }

  static std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }
  std::string_view header(http::field field) const { return view(parser_->get()[field]); }

  ByteStream stream_;
  Shared& shared_;
  std::string address_;
  asio::steady_timer timer_;
  std::optional<Connections::Place> place_;  // nothing: it is over, or a WebSocket
  beast::flat_buffer buffer_{kLargestHeader + 4096};
  std::optional<http::request_parser<http::empty_body>> parser_;
  int answered_ = 0;
};

}  // namespace

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
