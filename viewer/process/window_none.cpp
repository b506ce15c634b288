#include "viewer/process/window.hpp"

namespace marco::viewer {

std::unique_ptr<Window> open_window(const char* /*title*/) { return nullptr; }

}  // namespace marco::viewer
