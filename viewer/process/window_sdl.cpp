#include <SDL.h>

#include <algorithm>
#include <string>
#include <utility>

#include "viewer/process/window.hpp"

namespace marco::viewer {
namespace {

class SdlWindow : public Window {
 public:
  SdlWindow(SDL_Window* window, SDL_Renderer* renderer) : window_(window), renderer_(renderer) {}
  ~SdlWindow() override {
    if (texture_ != nullptr) SDL_DestroyTexture(texture_);
    SDL_DestroyRenderer(renderer_);
    SDL_DestroyWindow(window_);
    SDL_Quit();
  }
  SdlWindow(const SdlWindow&) = delete;
  SdlWindow& operator=(const SdlWindow&) = delete;

  void show(const Picture& picture) override {
    if (texture_ != nullptr) SDL_DestroyTexture(texture_);
    texture_ = SDL_CreateTexture(renderer_, SDL_PIXELFORMAT_RGB24, SDL_TEXTUREACCESS_STATIC,
                                 picture.width_px, picture.height_px);
    if (texture_ == nullptr) return;
    SDL_UpdateTexture(texture_, nullptr, picture.pixels.data(), 3 * picture.width_px);
    width_ = picture.width_px;
    height_ = picture.height_px;
    draw();
  }

  bool pump() override {
    SDL_Event event;
    bool open = true;
    while (SDL_PollEvent(&event) != 0) {
      if (event.type == SDL_QUIT) open = false;
      if (event.type == SDL_WINDOWEVENT) draw();
      if (event.type == SDL_KEYDOWN) take(event.key.keysym);
      if (event.type == SDL_CONTROLLERDEVICEADDED) SDL_GameControllerOpen(event.cdevice.which);
      if (event.type == SDL_CONTROLLERBUTTONDOWN) take(event.cbutton.button);
    }
    return open;
  }

  std::string take_keys() override { return std::exchange(keys_, {}); }

 private:
  void take(const SDL_Keysym& key) {
    const bool shift = (key.mod & KMOD_SHIFT) != 0;
    switch (key.sym) {
      case SDLK_UP:
        keys_ += 'a';
        break;
      case SDLK_DOWN:
        keys_ += 'r';
        break;
      case SDLK_LEFT:
        keys_ += 'i';
        break;
      case SDLK_RIGHT:
        keys_ += 'd';
        break;
      case SDLK_PAGEUP:
        keys_ += 'e';
        break;
      case SDLK_PAGEDOWN:
        keys_ += 'E';
        break;
      case SDLK_COMMA:
        keys_ += 'g';
        break;
      case SDLK_PERIOD:
        keys_ += 'G';
        break;
      default:
        if (key.sym >= SDLK_a && key.sym <= SDLK_z)
          keys_ += static_cast<char>(key.sym - (shift ? 'a' - 'A' : 0));
    }
  }
  void take(uint8_t button) {
    if (button == SDL_CONTROLLER_BUTTON_DPAD_UP) keys_ += 'a';
    if (button == SDL_CONTROLLER_BUTTON_DPAD_DOWN) keys_ += 'r';
    if (button == SDL_CONTROLLER_BUTTON_DPAD_LEFT) keys_ += 'i';
    if (button == SDL_CONTROLLER_BUTTON_DPAD_RIGHT) keys_ += 'd';
    if (button == SDL_CONTROLLER_BUTTON_Y) keys_ += 'e';
    if (button == SDL_CONTROLLER_BUTTON_A) keys_ += 'E';
    if (button == SDL_CONTROLLER_BUTTON_X) keys_ += 'g';
    if (button == SDL_CONTROLLER_BUTTON_B) keys_ += 'G';
  }
  void draw() {
    SDL_SetRenderDrawColor(renderer_, 255, 255, 255, 255);
    SDL_RenderClear(renderer_);
    if (texture_ != nullptr) {
      // As large as fits, its shape kept.
      int width = 0, height = 0;
      SDL_GetRendererOutputSize(renderer_, &width, &height);
      const double scale =
          std::min(static_cast<double>(width) / width_, static_cast<double>(height) / height_);
      SDL_Rect place{};
      place.w = static_cast<int>(scale * width_);
      place.h = static_cast<int>(scale * height_);
      place.x = (width - place.w) / 2;
      place.y = (height - place.h) / 2;
      SDL_RenderCopy(renderer_, texture_, nullptr, &place);
    }
    SDL_RenderPresent(renderer_);
  }

  SDL_Window* window_;
  SDL_Renderer* renderer_;
  SDL_Texture* texture_ = nullptr;
  int width_ = 1, height_ = 1;
  std::string keys_;
};

}  // namespace

std::unique_ptr<Window> open_window(const char* title) {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS,
              "1");  // SIGINT and SIGTERM end the program, not a window
  // SDL would show pictures through the system's OpenGL, whose symbols are OSMesa's in this
  // program.
  SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0");
  if (SDL_Init(SDL_INIT_VIDEO | SDL_INIT_GAMECONTROLLER) != 0) return nullptr;
  // Without a display SDL offers drivers that show nothing.
  const std::string driver = SDL_GetCurrentVideoDriver();
  SDL_Window* window = nullptr;
  if (driver != "dummy" && driver != "offscreen") {
    window = SDL_CreateWindow(title, SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, 900, 700,
                              SDL_WINDOW_RESIZABLE);
  }
  SDL_Renderer* renderer =
      window == nullptr ? nullptr : SDL_CreateRenderer(window, -1, SDL_RENDERER_SOFTWARE);
  if (renderer == nullptr) {
    if (window != nullptr) SDL_DestroyWindow(window);
    SDL_Quit();
    return nullptr;
  }
  return std::make_unique<SdlWindow>(window, renderer);
}

}  // namespace marco::viewer
