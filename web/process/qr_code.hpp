#pragma once

#include <string>

namespace marco::web {

/// A text as a QR code for a terminal of UTF-8, dark on white whatever its colours; "" on others,
/// for a text that is too long, and where libqrencode was not there when this was built.
std::string qr_code(const std::string& text);

}  // namespace marco::web
