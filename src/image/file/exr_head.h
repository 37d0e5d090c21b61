// The headers of an OpenEXR file, walked before OpenEXR reads the bytes. Problem: OpenEXR allocates what a length or a
// window says before reading, so that 154 bytes can take 1.8 GiB. Method: walk attributes, channels, windows and the
// size of the chunk tables, compare each with the bytes that follow, and report the memory that OpenEXR's buffers will
// take. Invariant: every attribute of a fixed size has that size, so that the walk and OpenEXR stay at the same byte.
// Source: openexr.com, "OpenEXR File Layout"; OpenEXR 3.1, the readValueFrom of each attribute.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace kiln {

/// The bytes of an EXR in memory or on the disk.
struct ExrBytes {
  std::uint64_t size = 0;
  /// Copies the bytes from `at` on. requires: they are in the file.
  std::function<void(std::uint64_t at, std::span<std::byte> out)> copy;
};

/// One part of a file. unit of windows: pixels.
struct ExrPart {
  std::int64_t x = 0, y = 0, width = 0, height = 0;  // the data window
  bool deep = false;
  std::string compression;  // none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab
  std::vector<std::pair<std::string, std::string>> channels{};  // name and type: uint, half or float
  /// The buffers in which OpenEXR unpacks rows or tiles. unit: bytes.
  std::uint64_t buffer_bytes = 0;
  /// Attributes of type string, by name.
  std::map<std::string, std::string> text;
};

/// All parts, in the order of the file. cost: reads the headers alone. throws: Error kFormat with the byte, where the
/// file is no EXR, a length goes beyond it, or an attribute that every part needs is missing; kUnsupported where a side
/// of a data window is not from 1 to 65536 pixels.
std::vector<ExrPart> readExrHead(const ExrBytes& bytes, const std::filesystem::path& path);

/// The bytes of a file in memory. requires: they outlive the result.
ExrBytes exrBytesOf(std::span<const std::byte> data);

}  // namespace kiln
