#pragma once

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/procman/wire.hpp"
#include "procman_lcm/deputy_info_t.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/orders_t.hpp"

namespace marco::procman {

namespace channels {
inline constexpr const char* kInfo = "PM_INFO";
inline constexpr const char* kOrders = marco::channels::kProcmanOrders;
inline constexpr const char* kOutput = "PM_OUTPUT";
inline constexpr const char* kDiscover = marco::channels::kProcmanDiscover;
inline constexpr const char* kOutputSpan = "PROCMAN_OUTPUT_SPAN";
}  // namespace channels

procman_lcm::deputy_info_t to_message(const DeputyInfo& info);
DeputyInfo from_message(const procman_lcm::deputy_info_t& message);

/// PM_DISCOVER: asks all deputies who is there.
procman_lcm::discovery_t discovery_message(const std::string& transmitter_id, int64_t nonce);

procman_lcm::orders_t to_message(const Orders& orders);
Orders from_message(const procman_lcm::orders_t& message);

}  // namespace marco::procman
