#include "tools/watch/window.hpp"

namespace marco::watch {

std::unique_ptr<Window> open_window(const char* /*title*/) { return nullptr; }

}  // namespace marco::watch
