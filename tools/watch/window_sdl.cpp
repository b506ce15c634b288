#include <SDL.h>

#include <algorithm>
#include <string>

#include "tools/watch/window.hpp"

namespace marco::watch {
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

  void show(const viewer::Picture& picture) override {
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
    }
    return open;
  }

 private:
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
};

}  // namespace

std::unique_ptr<Window> open_window(const char* title) {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS,
              "1");  // SIGINT and SIGTERM end the program, not a window
  if (SDL_Init(SDL_INIT_VIDEO) != 0) return nullptr;
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

}  // namespace marco::watch
