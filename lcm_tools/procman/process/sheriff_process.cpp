#include "lcm_tools/procman/process/sheriff_process.hpp"

#include <algorithm>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"

namespace marco::procman {
namespace {

constexpr std::size_t kMostOtherSheriffs = 1000;
constexpr int64_t kMaxWaitUs = 200'000;
constexpr int kMessagesPerStep = 200;  // a flood of messages must not delay orders and keys

std::string new_sheriff_id() {
  char host[256] = "localhost";
  gethostname(host, sizeof host - 1);
  return std::string(host) + ":" + std::to_string(getpid()) + ":" + std::to_string(wall_clock_us());
}

}  // namespace

SheriffProcess::SheriffProcess(const std::string& lcm_url, Config config, bool observer)
    : config_(std::move(config)),
      bus_(lcm_url),
      publisher_(bus_, [this](const std::string& failure) { log_.note(failure); }),
      state_(new_sheriff_id(), observer),
      watch_(bus_, monotonic_us()),
      emergency_stop_(bus_, drops_, "sheriff"),
      script_(bus_, config_, log_) {
  state_.load(config_);
  subscribe();
  ask_who_is_there();
}

void SheriffProcess::ask_who_is_there() {
  publisher_.publish(channels::kDiscover, discovery_message(state_.id(), 0));
}

void SheriffProcess::require_editable() const {
  require(!state_.observer(), "only watching; o = give orders");
  require(!script_.is_running(), "a script is running; a = abort it");
}

void SheriffProcess::put_command(const PlacedCommand& placed) {
  require_editable();
  const bool is_new = !state_.commands().contains(placed.command.id);
  procman::put_command(config_, placed);
  state_.put(placed);
  log_.note((is_new ? "new command " : "changed command ") + placed.command.id);
}

void SheriffProcess::remove_command(const std::string& id) {
  require_editable();
  state_.remove(id);
  procman::remove_command(config_, id);
  log_.note("removed command " + id);
}

void SheriffProcess::subscribe() {
  subscribe_checked<procman_lcm::deputy_info_t>(
      bus_, channels::kInfo, layouts::kInfo, drops_, [this](const auto& message) {
        for (const std::string& event :
             state_.on_info(from_message(message), wall_clock_us(), monotonic_us())) {
          log_.note(event);
        }
      });
  subscribe_checked<procman_lcm::orders_t>(bus_, channels::kOrders, layouts::kOrders, drops_,
                                           [this](const auto& message) {
                                             if (state_.on_orders(from_message(message)))
                                               on_other_sheriff(message.sheriff_id);
                                           });
  subscribe_checked<procman_lcm::output_span_t>(
      bus_, channels::kOutputSpan, layouts::kOutputSpan, drops_,
      [this](const auto& message) { log_.on_span(message); });
  subscribe_checked<procman_lcm::output_t>(
      bus_, channels::kOutput, layouts::kOutput, drops_,
      [this](const auto& message) { log_.on_output(message); });
}

void SheriffProcess::on_other_sheriff(const std::string& id) {
  if (state_.observer() || others_.ids.size() >= kMostOtherSheriffs) return;
  const bool is_guest = id.starts_with(kGuest);
  // A script must end: who is still at work then is noticed then.
  if (script_.is_running() && !is_guest) return;
  if (!others_.ids.insert(id).second) return;
  log_.note((is_guest ? "a guest gives an order: " : "another sheriff gives orders: ") + id);
  others_.is_new = !is_guest;
}

void SheriffProcess::step(int64_t max_wait_us, int extra_fd) {
  pollfd sources[] = {
      {signals_.fd(), POLLIN, 0}, {bus_.lcm().getFileno(), POLLIN, 0}, {extra_fd, POLLIN, 0}};
  heartbeat_.beat();
  poll_for(sources, bus_.waiting() ? 0 : script_.wait_us(std::min(max_wait_us, kMaxWaitUs)));
  signals_.take();
  if ((sources[2].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) signals_.on_hang_up();
  for (int n = 0; n < kMessagesPerStep && bus_.handle_once(0); ++n) {
  }
  for (const std::string& event : watch_.step_to(monotonic_us(), state_)) log_.note(event);
  emergency_stop_.step_to(monotonic_us());
  script_.step(state_);
  send_due_orders();
}

std::string SheriffProcess::running_text() const {
  std::string text;
  for (const std::string& id : state_.running()) text += (text.empty() ? "" : ", ") + id;
  return text;
}

std::vector<std::string> SheriffProcess::unsettled() const {
  std::vector<std::string> waiting;
  for (const auto& [id, command] : state_.commands()) {
    if (command.settled()) continue;
    waiting.push_back(command.reported ? id + ": " + status_text(command.status())
                                       : id + ": no deputy '" + command.deputy + "' answers");
  }
  return waiting;
}

void SheriffProcess::send_due_orders() {
  if (orders_held_) return;
  for (const Orders& orders : state_.take_due_orders(wall_clock_us(), monotonic_us())) {
    publisher_.publish(channels::kOrders, to_message(orders));
  }
}

}  // namespace marco::procman
