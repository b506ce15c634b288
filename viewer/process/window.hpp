#pragma once

#include <memory>
#include <string>

#include "viewer/picture.hpp"

namespace marco::viewer {

/// A window on the screen.
class Window {
 public:
  virtual ~Window() = default;
  virtual void show(const Picture& picture) = 0;
  /// Reads what the window system says. @returns false once the window was closed.
  virtual bool pump() = 0;
  /// Keys and gamepad buttons since the last call, as the letters of a walk (viewer/walk.hpp):
  /// arrow keys and the cross are a r i d, page up and down e and E, comma and full stop g and G.
  virtual std::string take_keys() = 0;
};

/// @returns nothing where there is no display, or this program was built without SDL2.
std::unique_ptr<Window> open_window(const char* title);

}  // namespace marco::viewer
