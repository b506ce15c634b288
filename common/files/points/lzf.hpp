#pragma once

#include <string>
#include <string_view>

namespace marco::files {

/// Unpacks what LZF packed, as PCD's binary_compressed has it.
/// @param bytes  of the unpacked data; no memory is taken for more than LZF can pack so small.
/// @throws std::invalid_argument beginning with `name` for data that give another number of bytes.
std::string unpack_lzf(std::string_view packed, std::size_t bytes, const std::string& name);

}  // namespace marco::files
