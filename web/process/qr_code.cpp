#include "web/process/qr_code.hpp"

#if MARCO_HAS_QRENCODE
#include <langinfo.h>
#include <qrencode.h>

#include <clocale>
#include <memory>
#include <string_view>

namespace marco::web {
namespace {

constexpr int kQuiet = 4;  // modules around it, of the standard

}  // namespace

std::string qr_code(const std::string& text) {
  setlocale(LC_CTYPE, "");
  if (std::string_view(nl_langinfo(CODESET)) != "UTF-8") return "";
  const std::unique_ptr<QRcode, void (*)(QRcode*)> code(
      QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_L), QRcode_free);
  if (code == nullptr) return "";
  const auto is_dark = [&](int x, int y) {
    const int size = code->width;
    return x >= 0 && y >= 0 && x < size && y < size && (code->data[y * size + x] & 1) != 0;
  };
  std::string drawn;
  for (int y = -kQuiet; y < code->width + kQuiet; y += 2) {
    drawn += "\x1b[30;107m";  // black on white
    for (int x = -kQuiet; x < code->width + kQuiet; ++x) {
      const bool upper = is_dark(x, y), lower = is_dark(x, y + 1);
      drawn += upper ? (lower ? "█" : "▀") : (lower ? "▄" : " ");
    }
    drawn += "\x1b[0m\n";
  }
  return drawn;
}

}  // namespace marco::web
#else
namespace marco::web {

std::string qr_code(const std::string& /*text*/) { return ""; }

}  // namespace marco::web
#endif
