#pragma once

#include "lcm_tools/tests/support/encoded.hpp"
