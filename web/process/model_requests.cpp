#include "web/process/model_requests.hpp"

#include "lcm_tools/process/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/map_request_t.hpp"

namespace marco::web {
namespace {

constexpr int64_t kWholeUs = 1'000'000;   // a sweep comes in several messages, one after another
constexpr int64_t kApartUs = 10'000'000;  // of two requests

}  // namespace

void ModelRequests::take(const process::RawMessage& message) {
  if (message.channel == channels::kScene) has_new_rows_ = true;
}

void ModelRequests::step(int64_t now_us, bool somebody_watches) {
  if (has_new_rows_) {
    has_new_rows_ = false;
    is_due_ = true;
    heard_us_ = now_us;
  }
  if (live_ == nullptr || !is_due_ || !somebody_watches) return;
  if (now_us - heard_us_ < kWholeUs || now_us - asked_us_ < kApartUs) return;
  is_due_ = false;
  asked_us_ = now_us;
  map_request_t request;
  request.utime = process::wall_clock_us();
  request.channel = channels::kMesh;
  live_->publish(channels::kMapRequest, request);
}

}  // namespace marco::web
