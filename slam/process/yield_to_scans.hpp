#pragma once

namespace marco::slam {

/// The calling thread from here on leaves the processor to the one that takes scans.
void yield_to_scans();

}  // namespace marco::slam
