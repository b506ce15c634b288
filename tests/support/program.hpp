#pragma once

#include "lcm_tools/tests/support/program.hpp"
