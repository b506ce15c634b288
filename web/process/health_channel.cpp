#include "web/process/health_channel.hpp"

#include <numeric>

#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/base_status_t.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "web/page_schemas.hpp"

namespace marco::web {
namespace {

constexpr int64_t kTellEveryUs = 1'000'000, kKeptUs = 30'000'000;
constexpr std::size_t kMostChannels = 1000;

std::vector<diagnosis::Expectation> expectations() {
  using diagnosis::Awaited;
  auto map = diagnosis::expect(Awaited::map);
  map.what = "map";  // after "no"
  map.without = "No map is drawn";
  return {diagnosis::expect_scans(channels::kLidarPattern, "LIDAR or LIDAR_RAW"),
          diagnosis::expect(Awaited::odometry), map};
}

std::string sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

}  // namespace

HealthChannel::HealthChannel(Hub& hub, const Source& source, const lcm_schema::Decoder& decoder)
    : hub_(hub),
      drops_(source.drops),
      channel_(add_page_channel(hub, "page/health")),
      is_live_(source.live != nullptr),
      decoder_(decoder) {
  subscribe(source.in);
  if (source.live == nullptr) {
    heard_ = std::make_unique<spy::SharedModel>(decoder_, spy::Keep::newest);
    return;
  }
  silence_ = std::make_unique<diagnosis::SilenceWatch>(
      *source.live,
      diagnosis::SilenceWatch::Options{"marco-page", source.lcm_url, expectations(), nullptr});
  try {
    url_ = diagnosis::parse_udp_url(process::effective_lcm_url(source.lcm_url));
  } catch (const std::invalid_argument&) {
  }
}

void HealthChannel::subscribe(process::Bus& in) {
  in.subscribe<process_status_t>(
      channels::kProcessStatus, drops_, [this](const process_status_t& status, const auto&) {
        const int64_t dropped =
            std::accumulate(status.drop_counts.begin(), status.drop_counts.end(), int64_t{0});
        health_.take_status(status.process, status.state, dropped, procman::monotonic_us());
      });
  in.subscribe<base_status_t>(
      channels::kBaseStatus, drops_, [this](const base_status_t& status, const auto&) {
        health_.take_base(status.base, status.link == base_status_t::LINK_UP, status.battery_v,
                          status.note, procman::monotonic_us());
      });
  in.subscribe<slam_pose_t>(
      channels::kSlamPose, drops_, [this](const slam_pose_t& pose, const process::RawMessage& raw) {
        const double age_s =
            1e-6 * (static_cast<double>(raw.event_time.us) - static_cast<double>(pose.utime));
        health_.take_pose_age(age_s, procman::monotonic_us());
      });
}

void HealthChannel::take(const process::RawMessage& message) {
  if (!is_live_) heard_->model.add_message(procman::monotonic_us(), message.channel, message.bytes);
}

// A socket of its own: losses show in the datagrams' numbers. It is kept for a while: its thread's
// end takes a tenth of a second, and clients come and go.
void HealthChannel::listen() {
  const int64_t now_us = procman::monotonic_us();
  if (hub_.wanted(channel_)) wanted_us_ = now_us;
  const bool is_wanted = wanted_us_ != 0 && now_us - wanted_us_ < kKeptUs;
  if (!is_live_ || !url_ || is_wanted == (receiver_ != nullptr)) return;
  receiver_.reset();
  heard_.reset();
  if (!is_wanted) return;
  heard_ = std::make_unique<spy::SharedModel>(decoder_, spy::Keep::newest);
  try {
    receiver_ = std::make_unique<spy::Receiver>(*url_, *heard_);
  } catch (const std::runtime_error&) {
    url_.reset();  // the port is taken: found by others
  }
}

std::vector<ChannelHealth> HealthChannel::channels() {
  if (!heard_) return {};
  // Live the model's clock is the kernel's, of arrival.
  const int64_t now_us = is_live_ ? process::wall_clock_us() : procman::monotonic_us();
  const spy::SharedModel::Look look(*heard_);
  heard_->model.settle(now_us);
  const spy::Model& model = heard_->model;
  std::vector<ChannelHealth> all;
  for (std::size_t i = 0; i < model.channels().size() && i < kMostChannels; ++i) {
    const spy::Channel& channel = model.channels()[i];
    const int type = channel.type();
    all.push_back(
        {channel.name,
         type < 0 ? "" : decoder_.schema().structures()[static_cast<std::size_t>(type)].name,
         channel.rate.recent(now_us).hz, model.loss(static_cast<int>(i)).count,
         1e-6 * static_cast<double>(std::max<int64_t>(0, now_us - channel.rate.last_us()))});
  }
  return all;
}

std::vector<HealthFinding> HealthChannel::lacking() const {
  std::vector<HealthFinding> findings;
  if (!silence_) return findings;
  for (const diagnosis::Lack& lack : silence_->lacks()) {
    const bool is_needed = lack.expected.without.empty();
    std::string text = sentence(diagnosis::short_state(lack));
    if (!is_needed) text += ". " + lack.expected.without;
    findings.push_back({is_needed, text, lack.expected.remedy});
  }
  for (const diagnosis::Finding& finding : silence_->network()) {
    findings.push_back({true, finding.text, finding.command});
  }
  return findings;
}

void HealthChannel::step(const std::function<std::vector<HealthFinding>()>& more) {
  if (silence_) diagnosis::log_note(silence_->step());
  listen();
  const int64_t now_us = procman::monotonic_us();
  if (!hub_.wanted(channel_) || now_us - told_us_ < kTellEveryUs) return;
  told_us_ = now_us;
  Surroundings around;
  around.channels = channels();
  around.findings = lacking();
  for (HealthFinding& finding : more()) around.findings.push_back(std::move(finding));
  around.clients = static_cast<int64_t>(hub_.clients());
  for (const auto& [cause, count] : drops_.by_cause()) {
    if (cause.starts_with("refused: ") || cause.starts_with("disconnected: "))
      around.refused += count;
  }
  around.dropped = hub_.dropped();
  const int64_t utime_us = process::wall_clock_us();
  hub_.publish(channel_, utime_us * 1000, health_.json(around, utime_us, now_us));
}

std::string HealthChannel::state(const std::string& otherwise) const {
  return silence_ ? silence_->state(otherwise) : otherwise;
}

}  // namespace marco::web
