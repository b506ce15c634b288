#include "lcm_tools/spy/jpeg.hpp"

#include <csetjmp>
#include <cstdio>
// libjpeg's header needs <cstdio> before it.
#include <jpeglib.h>

namespace marco::spy {
namespace {

// libjpeg reports errors through functions that must not return.
struct Decoder : jpeg_decompress_struct {
  Decoder() : jpeg_decompress_struct{} {
    err = jpeg_std_error(&errors);
    errors.error_exit = [](j_common_ptr info) {
      std::longjmp(static_cast<Decoder*>(reinterpret_cast<j_decompress_ptr>(info))->failed, 1);
    };
    errors.output_message = [](j_common_ptr) {};  // stderr is the spy's screen
    jpeg_create_decompress(this);
  }
  ~Decoder() { jpeg_destroy_decompress(this); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  jpeg_error_mgr errors{};
  std::jmp_buf failed{};
};

// No local object here may have a destructor: longjmp would skip it.
bool decode(Decoder& decoder, std::span<const uint8_t> bytes, GrayImage& image) {
  constexpr int64_t kMostPixels = 1 << 26;
  if (setjmp(decoder.failed) != 0) return false;  // NOLINT(cert-err52-cpp): libjpeg's way
  jpeg_mem_src(&decoder, bytes.data(), bytes.size());
  jpeg_read_header(&decoder, TRUE);
  decoder.out_color_space = JCS_GRAYSCALE;
  decoder.scale_num = 1;
  decoder.scale_denom = 2;
  jpeg_start_decompress(&decoder);
  if (int64_t{decoder.output_width} * decoder.output_height > kMostPixels) return false;
  image.width = static_cast<int>(decoder.output_width);
  image.height = static_cast<int>(decoder.output_height);
  image.pixels.resize(std::size_t{decoder.output_width} * decoder.output_height);
  while (decoder.output_scanline < decoder.output_height) {
    JSAMPROW row =
        image.pixels.data() + std::size_t{decoder.output_scanline} * decoder.output_width;
    if (jpeg_read_scanlines(&decoder, &row, 1) == 0) return false;
  }
  return true;
}

}  // namespace

std::optional<GrayImage> decode_jpeg(std::span<const uint8_t> bytes) {
  Decoder decoder;
  GrayImage image;
  if (!decode(decoder, bytes, image)) return {};
  return image;
}

}  // namespace marco::spy
