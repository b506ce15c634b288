#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// YDLIDAR's serial protocol (X2, X4, G4): requests A5 command, without a checksum; replies with a
/// header A5 5A; packets AA 55 of some samples. From the maker's development manuals and
/// YDLidar-SDK; no device was at hand. Not read: intensities of ten bits (G4B: their upper two are
/// lost), and time-of-flight models that send no intensity, whose packets look like an X4's.
namespace marco::drivers::ydlidar {

using Bytes = std::vector<uint8_t>;

inline constexpr uint8_t kRequestMark = 0xA5;
/// The first two bytes of what the laser sends, as little-endian words.
inline constexpr unsigned kReplyMark = 0x5AA5;
inline constexpr unsigned kPacketMark = 0x55AA;
inline constexpr unsigned kStampMark = 0x66AA;  ///< of newer firmware, between packets

inline constexpr uint8_t kForceStop = 0x00;
inline constexpr uint8_t kScan = 0x60;
inline constexpr uint8_t kStop = 0x65;
inline constexpr uint8_t kReset = 0x40;
inline constexpr uint8_t kResetToo = 0x80;  ///< of newer manuals
inline constexpr uint8_t kGetInfo = 0x90;
inline constexpr uint8_t kGetHealth = 0x91;     ///< of the manuals
inline constexpr uint8_t kGetHealthToo = 0x92;  ///< of the SDK
inline constexpr uint8_t kGetFrequency = 0x0D;
inline constexpr uint8_t kGetSampleRate = 0xD1;

/// Kinds in a reply's header.
inline constexpr uint8_t kInfo = 0x04;  ///< and single values
inline constexpr uint8_t kHealth = 0x06;
inline constexpr uint8_t kPackets = 0x81;

inline constexpr std::size_t kHeaderSize = 7;
inline constexpr std::size_t kInfoSize = 20;
inline constexpr std::size_t kHealthSize = 3;
inline constexpr std::size_t kPacketHeadSize = 10;
inline constexpr int kMaxSamples = 80;

Bytes encode_request(uint8_t command);
/// @param stream  packets follow, without end.
Bytes encode_header(uint32_t length, bool stream, uint8_t kind);

/// How a sample is written.
enum class SampleForm {
  range,          ///< u16: mm * 4
  intensity,      ///< u8 intensity, then the same; its two low bits are flags
  wide_intensity  ///< time of flight: u16 intensity, u16 mm
};
std::size_t sample_size(SampleForm form);

struct Sample {
  double range_mm = 0.0;  ///< 0 = none
  int intensity = 0;      ///< 0 where the form has none
  bool operator==(const Sample&) const = default;
};

struct Packet {
  bool turn_start = false;  ///< its one sample is the first of a turn
  int frequency_dhz = 0;    ///< turns a second, 0.1 Hz; 0 where the firmware does not say
  int first_q6 = 0;         ///< angle of the first sample, 1/64 deg, clockwise, uncorrected
  int last_q6 = 0;
  std::vector<Sample> samples;  ///< 1..kMaxSamples
};
/// Ranges are rounded to the form's unit. @throws std::invalid_argument for a wrong number of
/// samples.
Bytes encode_packet(const Packet& packet, SampleForm form);
/// Size of the packet that begins here. @param head  kPacketHeadSize bytes at least.
/// @returns nothing when no packet begins so.
std::optional<std::size_t> packet_size(std::span<const uint8_t> head, SampleForm form);
/// @param bytes  of packet_size(). @returns nothing when the checksum is wrong.
std::optional<Packet> decode_packet(std::span<const uint8_t> bytes, SampleForm form);

/// Angle of sample i before its correction [deg, 0..360), clockwise.
double sample_angle_deg(const Packet& packet, std::size_t i);
/// What to add to the angle, because the laser sits beside the camera that measures by
/// triangulation; 0 without a range.
double angle_correction_deg(double range_mm);

struct DeviceInfo {
  int model = 0;
  int firmware_major = 0;
  int firmware_minor = 0;
  int hardware = 0;
};
/// @param data  of a reply of kInfoSize.
DeviceInfo decode_info(std::span<const uint8_t> data);
/// "X4"; "model 77" when it is not known.
std::string model_name(int model);

}  // namespace marco::drivers::ydlidar
