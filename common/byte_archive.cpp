#include "common/byte_archive.hpp"

#include <zlib.h>

namespace marco {
namespace {

constexpr std::size_t kNameBytes = 8;
constexpr std::size_t kHeadBytes = kNameBytes + sizeof(uint32_t) + sizeof(uint64_t);

template <class T>
T number_at(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

}  // namespace

std::size_t ByteWriter::length(std::size_t count, std::size_t) {
  uint64_t length = count;
  raw(&length, sizeof(length));
  return count;
}

std::size_t ByteReader::length(std::size_t, std::size_t element_bytes) {
  uint64_t length = 0;
  raw(&length, sizeof(length));
  require(length <= left() / element_bytes, "is truncated");
  return length;
}

uint32_t crc32(std::string_view bytes) {
  const auto crc = ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  return static_cast<uint32_t>(crc);
}

std::string seal(std::string_view name, uint32_t version, std::string_view payload) {
  require(name.size() == kNameBytes, "a sealed file's name has 8 letters");
  const uint64_t length = payload.size();
  std::string sealed(name);
  sealed.reserve(kHeadBytes + payload.size() + sizeof(uint32_t));
  sealed.append(reinterpret_cast<const char*>(&version), sizeof(version));
  sealed.append(reinterpret_cast<const char*>(&length), sizeof(length));
  sealed.append(payload);
  const uint32_t crc = crc32(sealed);
  sealed.append(reinterpret_cast<const char*>(&crc), sizeof(crc));
  return sealed;
}

std::string_view unseal(std::string_view name, uint32_t version, std::string_view sealed) {
  return unseal(name, version, version, sealed).payload;
}

Unsealed unseal(std::string_view name, uint32_t oldest, uint32_t newest, std::string_view sealed) {
  require(sealed.substr(0, kNameBytes) == name, "is no " + std::string(name) + " file");
  require(sealed.size() >= kHeadBytes + sizeof(uint32_t), "is truncated");
  const auto found = number_at<uint32_t>(sealed, kNameBytes);
  const auto length = number_at<uint64_t>(sealed, kNameBytes + sizeof(uint32_t));
  require(length == sealed.size() - kHeadBytes - sizeof(uint32_t), "is truncated");
  const std::size_t end = sealed.size() - sizeof(uint32_t);
  require(number_at<uint32_t>(sealed, end) == crc32(sealed.substr(0, end)), "is damaged");
  require(found >= oldest && found <= newest,
          "is of version " + std::to_string(found) + "; this program reads version " +
              std::to_string(newest) +
              (found < oldest ? ": open it with the release that wrote it, or start without it"
                              : ": a newer release wrote it"));
  return {sealed.substr(kHeadBytes, length), found};
}

}  // namespace marco
