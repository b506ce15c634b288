#pragma once

#include <algorithm>
#include <array>
#include <string_view>

/// The channels of lcm_tools' own messages. The .lcm files next to this header define the messages.
namespace marco::channels {

inline constexpr const char* kEmergencyStop = "EMERGENCY_STOP";  ///< emergency_stop_t: all bases
inline constexpr const char* kProcessStatus = "PROCESS_STATUS";  ///< process_status_t
inline constexpr const char* kProcmanOrders = "PM_ORDERS";       ///< procman_lcm.orders_t
inline constexpr const char* kProcmanDiscover = "PM_DISCOVER";   ///< procman_lcm.discovery_t

/// Orders and the call that makes deputies answer, also those of libbot2's procman. A player of
/// recordings leaves these channels out, or running robots obey the recorded orders.
inline constexpr std::array<std::string_view, 5> kToolOrders = {
    kEmergencyStop, kProcmanOrders, kProcmanDiscover, "PMD_ORDERS", "PMD_ORDERS2"};

}  // namespace marco::channels
