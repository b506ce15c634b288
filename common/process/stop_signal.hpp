#pragma once

namespace marco::process {

/// Makes SIGINT and SIGTERM set a flag instead of ending the process. Call once, from main.
void catch_stop_signals();

/// Whether one of them came.
bool stop_requested();

}  // namespace marco::process
