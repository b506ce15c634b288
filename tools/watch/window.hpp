#pragma once

#include <memory>

#include "viewer/picture.hpp"

namespace marco::watch {

/// A window on the screen.
class Window {
 public:
  virtual ~Window() = default;
  virtual void show(const viewer::Picture& picture) = 0;
  /// Reads what the window system says. @returns false once the window was closed.
  virtual bool pump() = 0;
};

/// @returns nothing where there is no display, or this program was built without SDL2.
std::unique_ptr<Window> open_window(const char* title);

}  // namespace marco::watch
