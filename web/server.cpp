#include "web/server.hpp"

#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <stdexcept>

#include "web/connection.hpp"
#include "web/steady_clock.hpp"

namespace marco::web {
namespace {

constexpr int kMostAtOnce = 200;  // LCM's messages have their turn
constexpr int kAcceptedAtOnce = 16;
constexpr double kTurnsS = 0.0005;  // a stop may have come meanwhile

}  // namespace

struct Server::State {
  State(const Access& access, const Site& site, Hub& hub, process::DropCounter& drops)
      : shared{access, site, hub, drops} {}

  void listen(const ServerOptions& options);
  void accept();

  Shared shared;  // connections, which the context holds, use it to their end
  std::optional<Tls> tls;
  asio::io_context io{1};
  Tcp::acceptor acceptor{io};
  asio::steady_timer retry{io};
  asio::posix::stream_descriptor other{io};
  bool waits_for_other = false;
};

void Server::State::listen(const ServerOptions& options) {
  const std::string where = options.address + ":" + std::to_string(options.port);
  try {
    if (!options.certificate.empty()) tls.emplace(options.certificate, options.key);
    const Tcp::endpoint endpoint(asio::ip::make_address(options.address), options.port);
    acceptor.open(endpoint.protocol());
    acceptor.set_option(asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen(asio::socket_base::max_listen_connections);
    acceptor.non_blocking(true);
  } catch (const boost::system::system_error& failure) {
    throw std::runtime_error("cannot listen on " + where + ": " + failure.code().message() +
                             (failure.code() == asio::error::address_in_use
                                  ? "; another marco-page runs there, or give --listen another port"
                                  : ""));
  }
  accept();
}

void Server::State::accept() {
  acceptor.async_wait(Tcp::acceptor::wait_read, [this](error_code error) {
    if (error) return;
    // Several, or a crowd that comes and goes would keep the others waiting.
    for (int n = 0; n < kAcceptedAtOnce && !error; ++n) {
      Tcp::socket socket(io);
      acceptor.accept(socket, error);
      if (!error) start_connection(std::move(socket), shared, tls ? &*tls : nullptr);
    }
    if (!error || error == asio::error::would_block) return accept();
    // Out of descriptors, perhaps: others end soon.
    shared.drops.count("refused: " + error.message());
    retry.expires_after(std::chrono::milliseconds(100));
    retry.async_wait([this](error_code cancelled) {
      if (!cancelled) accept();
    });
  });
}

Server::Server(const ServerOptions& options,
               const Access& access,
               const Site& site,
               Hub& hub,
               process::DropCounter& drops)
    : state_(std::make_unique<State>(access, site, hub, drops)) {
  state_->listen(options);
}

Server::~Server() {
  state_->shared.hub.turns().clear();
  // Clients of the hub are closed by their connections, which the context holds.
  if (state_->other.is_open()) state_->other.release();
}

std::string Server::url() const {
  const Tcp::endpoint at = state_->acceptor.local_endpoint();
  const std::string address = at.address().to_string();
  return std::string(state_->tls ? "https://" : "http://") +
         (at.address().is_v6() ? "[" + address + "]" : address) + ":" + std::to_string(at.port()) +
         "/";
}

void Server::step(int other, int timeout_ms) {
  State& state = *state_;
  if (other >= 0 && !state.other.is_open()) state.other.assign(other);
  if (other >= 0 && !state.waits_for_other) {
    state.waits_for_other = true;
    state.other.async_wait(asio::posix::stream_descriptor::wait_read,
                           [&state](error_code) { state.waits_for_other = false; });
  }
  state.io.restart();
  Turns& turns = state.shared.hub.turns();
  const std::chrono::milliseconds wait(turns.empty() ? timeout_ms : 0);
  if (state.io.run_one_for(wait) > 0) {
    for (int n = 0; n < kMostAtOnce && state.io.poll_one() > 0; ++n) {
    }
  }
  const double end_s = steady_s() + kTurnsS;
  do {
    turns.take_one();
  } while (!turns.empty() && steady_s() < end_s);
}

}  // namespace marco::web
