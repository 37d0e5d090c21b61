// Checks the headers of an OpenEXR file before OpenEXR reads the bytes.
// Problem. OpenEXR allocates by lengths and windows of the file before reading: 154 bytes can take 1.8 GiB.
// Method. Walks attributes, channels, windows and the size of the chunk tables, compares each length with the bytes
// that follow, and computes the memory of OpenEXR's buffers.
// Invariant. Every attribute of a fixed size has exactly this size, so the walk and OpenEXR stay at the same byte.
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

/// The bytes of an EXR file in memory or on disk.
struct ExrBytes {
  std::uint64_t size = 0;
  /// Copies the bytes from `at` on. requires: the range lies in the file.
  std::function<void(std::uint64_t at, std::span<std::byte> out)> copy;
};

/// One part of a file. unit of windows: pixels.
struct ExrPart {
  std::int64_t x = 0, y = 0, width = 0, height = 0;  // the data window
  bool deep = false;
  std::string compression;  // none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab
  std::vector<std::pair<std::string, std::string>> channels{};  // name and type: uint, half or float
  /// Buffers in which OpenEXR unpacks rows or tiles. unit: bytes.
  std::uint64_t buffer_bytes = 0;
  /// String attributes by name.
  std::map<std::string, std::string> text;
};

/// Returns all parts in file order. cost: reads headers only.
/// throws: Error kFormat, with the byte offset, if the file is no EXR, a length exceeds the file, or a required
/// attribute is missing; kUnsupported if a side of a data window is not from 1 to 65536 pixels.
std::vector<ExrPart> readExrHead(const ExrBytes& bytes, const std::filesystem::path& path);

/// Wraps a file in memory. requires: `data` outlives the result.
ExrBytes exrBytesOf(std::span<const std::byte> data);

}  // namespace kiln
