#include "drivers/devices/port_identity.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace marco::drivers::devices {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

struct Maker {
  std::string_view id;  ///< of its maker, or of one product
  std::string_view what;
};

// Bridges that lasers and bases are sold with, boards of home-made bases, Hokuyo's own.
constexpr std::array kAsked{
    std::string_view("10c4:ea60"), std::string_view("0403:"),     std::string_view("067b:"),
    std::string_view("1a86:"),     std::string_view("0483:5740"), std::string_view("15d1:"),
    std::string_view("2341:"),     std::string_view("2a03:"),     std::string_view("303a:"),
    std::string_view("2e8a:"),     std::string_view("16c0:")};
constexpr std::array kLeftAlone{Maker{"1546:", "a u-blox satellite receiver"},
                                Maker{"091e:", "a Garmin satellite receiver"},
                                Maker{"12d1:", "a modem"},
                                Maker{"1199:", "a modem"},
                                Maker{"2c7c:", "a modem"},
                                Maker{"1bc7:", "a modem"},
                                Maker{"19d2:", "a modem"},
                                Maker{"1e0e:", "a modem"}};

}  // namespace

PortIdentity identify_port(const std::string& path, const std::string& classes) {
  std::error_code error;
  const fs::path port = fs::weakly_canonical(path, error);
  fs::path folder = fs::canonical(fs::path(classes) / port.filename() / "device", error);
  if (error) return {};
  for (; folder.has_relative_path(); folder = folder.parent_path()) {
    if (!fs::exists(folder / "idVendor", error)) continue;
    return {first_line(folder / "idVendor") + ":" + first_line(folder / "idProduct"),
            first_line(folder / "manufacturer"), first_line(folder / "product"),
            first_line(folder / "serial")};
  }
  return {};
}

std::string describe(const PortIdentity& identity) {
  if (identity.usb_id.empty()) return {};
  std::string text = "USB " + identity.usb_id;
  if (!identity.product.empty()) text += ", " + identity.product;
  return text;
}

std::string why_not_asked(const PortIdentity& identity) {
  if (identity.usb_id.empty()) return "it is not on USB, so any device may be there";
  const auto begins = [&identity](std::string_view id) { return identity.usb_id.starts_with(id); };
  for (const Maker& maker : kLeftAlone) {
    if (begins(maker.id)) return "USB " + identity.usb_id + " is " + std::string(maker.what);
  }
  if (std::any_of(kAsked.begin(), kAsked.end(), begins)) return {};
  return "USB " + identity.usb_id + " is unknown to Marco";
}

}  // namespace marco::drivers::devices
