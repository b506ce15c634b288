#pragma once

#include "lcm_tools/tests/support/temporary_folder.hpp"
