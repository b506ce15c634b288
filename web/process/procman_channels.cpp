#include "web/process/procman_channels.hpp"

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"
#include "web/foxglove/json.hpp"
#include "web/foxglove/messages.hpp"
#include "web/foxglove/schemas.hpp"
#include "web/page_schemas.hpp"

namespace marco::web {
namespace {

using foxglove::text_json;
using procman::Status;

constexpr std::size_t kNewestLines = 500, kNewestBytes = std::size_t{1} << 20;
constexpr int64_t kTellAgainUs = 1'000'000, kSilentUs = 5'000'000;

const char* word_of(Status status) {
  switch (status) {
    case Status::unknown:
      return "unknown";
    case Status::starting:
      return "starting";
    case Status::restarting:
      return "restarting";
    case Status::running:
      return "running";
    case Status::stopping:
      return "stopping";
    case Status::stopped_ok:
      return "stopped";
    case Status::stopped_error:
      return "failed";
  }
  return "";
}

}  // namespace

ProcmanChannels::ProcmanChannels(Hub& hub,
                                 process::DropCounter& drops,
                                 process::Bus& in,
                                 process::Bus* orders)
    : hub_(hub),
      orders_(orders),
      commands_(add_page_channel(hub, "page/commands")),
      output_(add_page_channel(hub, "page/output")),
      log_(hub.add_channel("/log", "foxglove.Log", foxglove::schema_of("foxglove.Log"))),
      state_(procman::kGuest + ("marco-page:" + std::to_string(process::wall_clock_us())), true),
      lines_(kNewestLines) {
  using namespace procman;  // NOLINT(google-build-using-namespace): its messages and layouts
  subscribe_checked<procman_lcm::deputy_info_t>(
      in, procman::channels::kInfo, layouts::kInfo, drops, [this](const auto& message) {
        state_.on_info(from_message(message), process::wall_clock_us(), procman::monotonic_us());
      });
  subscribe_checked<procman_lcm::orders_t>(
      in, procman::channels::kOrders, layouts::kOrders, drops,
      [this](const auto& message) { state_.on_orders(from_message(message)); });
  subscribe_checked<procman_lcm::output_span_t>(
      in, procman::channels::kOutputSpan, layouts::kOutputSpan, drops, [this](const auto& message) {
        std::vector<OutputSpan> spans;
        for (std::size_t i = 0; i < message.command_ids.size(); ++i) {
          spans.push_back({message.command_ids[i], message.first_bytes[i], message.end_bytes[i],
                           message.files[i]});
        }
        lines_.on_span(message.deputy_id, message.utime, std::move(spans));
      });
  subscribe_checked<procman_lcm::output_t>(
      in, procman::channels::kOutput, layouts::kOutput, drops, [this](const auto& message) {
        for (const auto& [id, line] : lines_.on_output(message.deputy_id, message.utime,
                                                       message.command_ids, message.text)) {
          take_line(id.empty() ? message.deputy_id : id, procman::printable(line));
        }
      });
  if (orders_ != nullptr) {
    orders_->publish(procman::channels::kDiscover, discovery_message(state_.id(), 0));
  }
}

void ProcmanChannels::take_line(const std::string& command, const std::string& line) {
  newest_.emplace_back(command, line);
  newest_bytes_ += command.size() + line.size();
  while (newest_.size() > kNewestLines || newest_bytes_ > kNewestBytes) {
    newest_bytes_ -= newest_.front().first.size() + newest_.front().second.size();
    newest_.pop_front();
  }
  const int64_t now_us = process::wall_clock_us();
  if (hub_.wanted(output_)) {
    hub_.publish(output_, now_us * 1000,
                 R"({"command":)" + text_json(command) + R"(,"text":)" + text_json(line) + "}",
                 ++next_line_);
  }
  if (hub_.wanted(log_)) {
    hub_.publish(log_, now_us * 1000,
                 foxglove::log_line(now_us, foxglove::Level::info, command, line), ++next_line_);
  }
}

std::string ProcmanChannels::commands_json(int64_t now_us) const {
  std::string json = R"({"deputies":[)";
  for (const auto& [id, deputy] : state_.deputies()) {
    json += (json.back() == '[' ? "" : ",") + text_json(id);
  }
  json += R"(],"commands":[)";
  for (const auto& [id, command] : state_.commands()) {
    const auto deputy = state_.deputies().find(command.deputy);
    const bool is_silent =
        deputy == state_.deputies().end() || now_us - deputy->second.heard_us > kSilentUs;
    json += (json.back() == '[' ? R"({"name":)" : R"(,{"name":)") + text_json(id) + R"(,"group":)" +
            text_json(command.spec.group) + R"(,"host":)" + text_json(command.deputy) +
            R"(,"state":")" + (is_silent ? "unknown" : word_of(command.status())) + R"(","exec":)" +
            text_json(command.spec.exec) + "}";
  }
  return json + "]}";
}

void ProcmanChannels::step(int64_t now_us) {
  constexpr int64_t kLookEveryUs = 200'000;
  if (!hub_.wanted(commands_) || now_us - looked_us_ < kLookEveryUs) return;
  looked_us_ = now_us;
  std::string json = commands_json(now_us);
  if (json == told_ && now_us - told_us_ < kTellAgainUs) return;
  told_ = json;
  told_us_ = now_us;
  hub_.publish(commands_, process::wall_clock_us() * 1000, std::move(json));
}

void ProcmanChannels::send_known(Hub::ClientId client, uint32_t channel) {
  const int64_t now_ns = process::wall_clock_us() * 1000;
  if (channel == commands_) {
    hub_.publish_to(client, commands_, now_ns, commands_json(procman::monotonic_us()));
  }
  if (channel != output_) return;
  for (const auto& [command, line] : newest_) {
    hub_.publish_to(client, output_, now_ns,
                    R"({"command":)" + text_json(command) + R"(,"text":)" + text_json(line) + "}",
                    ++next_line_);
  }
}

std::string ProcmanChannels::order(const std::string& command, const std::string& action) {
  require(orders_ != nullptr, "a recording takes no orders");
  const procman::Orders orders =
      state_.single_order(command, action, process::wall_clock_us(), procman::monotonic_us());
  orders_->publish(procman::channels::kOrders, procman::to_message(orders));
  return action + " " + command;
}

std::vector<ProcmanChannels::Trouble> ProcmanChannels::troubles() const {
  std::vector<Trouble> troubles;
  for (const auto& [id, command] : state_.commands()) {
    if (command.status() != Status::stopped_error || !command.reported) continue;
    troubles.push_back({id, procman::describe_exit(command.reported->exit_code)});
  }
  return troubles;
}

std::vector<std::string> ProcmanChannels::ended_programs() const {
  std::vector<std::string> programs;
  for (const auto& [id, command] : state_.commands()) {
    if (command.status() != Status::stopped_ok) continue;
    const std::string program = command.spec.exec.substr(0, command.spec.exec.find(' '));
    programs.push_back(program.substr(program.rfind('/') + 1));
  }
  return programs;
}

}  // namespace marco::web
