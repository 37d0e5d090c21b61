// Pixels of DICOM files. Known because the files are written here element by element, or, for the real slices, because
// a NRRD file holds equal voxels.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "base/error.h"
#include "ingest/open_source.h"
#include "support/files/dicom_files.h"
#include "support/files/foreign_files.h"
#include "support/system/sanitized.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr Extent3 kSeriesDims = {21, 18, 5};
constexpr VoxelType kTypes[] = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16,
                                VoxelType::i16, VoxelType::u32, VoxelType::i32};

// Describes `frames` slices of a volume from `z` on.
DicomSpec specOf(const ForeignVolume& volume, std::int64_t z, int frames, DicomSyntax syntax) {
  DicomSpec spec;
  spec.syntax = syntax;
  spec.columns = static_cast<int>(volume.dims.x);
  spec.rows = static_cast<int>(volume.dims.y);
  spec.frames = frames;
  spec.bits_allocated = spec.bits_stored = static_cast<int>(sizeOf(volume.type)) * 8;
  spec.is_signed = volume.type == VoxelType::i8 || volume.type == VoxelType::i16 || volume.type == VoxelType::i32;
  spec.position = "0\\0\\" + std::to_string(z);
  const std::size_t slice = static_cast<std::size_t>(volume.dims.x * volume.dims.y) * sizeOf(volume.type);
  spec.pixel_bytes = volume.stored(syntax == DicomSyntax::kExplicitBig)
                         .substr(static_cast<std::size_t>(z) * slice, static_cast<std::size_t>(frames) * slice);
  return spec;
}

// The names are in the opposite order of the slices.
void writeSlices(const ForeignFiles& files, const ForeignVolume& volume, DicomSyntax syntax = {}) {
  for (std::int64_t z = 0; z < volume.dims.z; ++z) {
    files.write("s" + std::to_string(volume.dims.z - z), dicomFile(specOf(volume, z, 1, syntax)));
  }
}

TEST(IngestDicom, EveryTypeAndSyntaxGivesTheValuesBack) {
  std::uint64_t seed = 1;
  for (const DicomSyntax syntax : {DicomSyntax::kExplicitLittle, DicomSyntax::kImplicitLittle,
                                   DicomSyntax::kExplicitBig, DicomSyntax::kDeflated}) {
    for (const VoxelType type : kTypes) {
      SCOPED_TRACE(testing::Message() << nameOf(type) << " syntax " << static_cast<int>(syntax));
      const ForeignFiles files;
      const ForeignVolume volume = randomVolume(kSeriesDims, type, seed);
      writeSlices(files, volume, syntax);
      expectReadsBack(volume, files.directory(), seed++);
      const ForeignFiles one;
      const auto path = one.write("all.dcm", dicomFile(specOf(volume, 0, static_cast<int>(kSeriesDims.z), syntax)));
      expectReadsBack(volume, path, seed++);
    }
  }
}

// Known: equal elements after another preamble, or, as in old archives, without a preamble.
TEST(IngestDicom, PreambleOfATiffOrNone_isReadAsDicom) {
  const ForeignVolume volume = randomVolume(kSeriesDims, VoxelType::i16, 40);
  for (const DicomPreamble preamble : {DicomPreamble::kTiff, DicomPreamble::kNone}) {
    for (const DicomSyntax syntax :
         {DicomSyntax::kExplicitLittle, DicomSyntax::kImplicitLittle, DicomSyntax::kExplicitBig}) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(preamble) << " " << static_cast<int>(syntax));
      const ForeignFiles files;
      for (std::int64_t z = 0; z < volume.dims.z; ++z) {
        DicomSpec spec = specOf(volume, z, 1, syntax);
        spec.preamble = preamble;
        files.write("s" + std::to_string(z), dicomFile(spec));
      }
      expectReadsBack(volume, files.directory(), 41);
      DicomSpec spec = specOf(volume, 0, static_cast<int>(volume.dims.z), syntax);
      spec.preamble = preamble;
      const ForeignFiles one;
      expectReadsBack(volume, one.write("all.dcm", dicomFile(spec)), 42);
    }
  }
}

// Old magic, no DICOM: the bytes begin like an element and continue differently.
TEST(IngestDicom, RawBytesThatBeginLikeAnElement_areNotDicom) {
  const ForeignFiles files;
  for (const std::string& bytes :
       {std::string("\x08\0\0\0\4\0\0\0", 8) + std::string(600, '\x11'),
        std::string("\x08\0\5\0", 4) + "CS" + std::string(600, '\x22'), std::string(8, '\0')})
    expectRefused(files.write("a.raw", bytes), ErrorCode::kUsage, "not a format that is known");
}

// Damage before the first frame, for which GDCM crashes: segments are checked before GDCM reads them.
TEST(IngestDicom, JpegSegmentsThatAreDamaged_areErrors) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({24, 20, 1}, VoxelType::u16, 43);
  const auto path = files.write("a.dcm", dicomFile(specOf(volume, 0, 1, {})));
  compressDicom(path, DicomCodec::kJpegLossless);
  const std::string whole = bytesOf(path);
  const std::size_t begin = whole.find("\xff\xd8\xff"), scan = whole.find("\xff\xda", begin);
  ASSERT_NE(scan, std::string::npos);
  int errors = 0;
  for (std::size_t at = begin; at < scan + 10; ++at) {
    for (const int bit : {0, 3, 5, 7}) {
      std::string damaged = whole;
      damaged[at] ^= static_cast<char>(1 << bit);
      files.write("a.dcm", damaged);
      testing::internal::CaptureStderr();
      try {
        readWhole(*openSource(path));
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kFormat) << error.what();
        ++errors;
      }
      testing::internal::GetCapturedStderr();
    }
  }
  EXPECT_GT(errors, 0);
  std::string marker = whole;
  marker[begin + 3] = 0;
  expectRefused(files.write("a.dcm", marker), ErrorCode::kFormat, "that are no segment of JPEG");
}

TEST(IngestDicom, CompressedFramesAreDecoded) {
  std::uint64_t seed = 100;
  for (const DicomCodec codec :
       {DicomCodec::kRle, DicomCodec::kJpegLossless, DicomCodec::kJpegLs, DicomCodec::kJpeg2000}) {
    for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::i16}) {
      SCOPED_TRACE(testing::Message() << nameOf(type) << " codec " << static_cast<int>(codec));
      const ForeignFiles files;
      const ForeignVolume volume = randomVolume({64, 48, 4}, type, seed);
      writeSlices(files, volume);
      for (int i = 1; i <= 4; ++i) compressDicom(files.directory() / ("s" + std::to_string(i)), codec);
      EXPECT_GT(openSource(files.directory())->decodeBytes(), 0u);
      expectReadsBack(volume, files.directory(), seed++);
      const ForeignFiles one;
      const auto path = one.write("all.dcm", dicomFile(specOf(volume, 0, 4, {})));
      compressDicom(path, codec);
      expectReadsBack(volume, path, seed++);
    }
  }
}

// Returns the file with another value of an element of type short, in explicit little endian.
std::string withShort(std::string file, const std::string& element, int value) {
  const std::size_t at = file.find(element + std::string("US\2\0", 4));
  EXPECT_NE(at, std::string::npos);
  file[at + 8] = static_cast<char>(value & 255), file[at + 9] = static_cast<char>(value >> 8);
  return file;
}
const std::string kRows("\x28\0\x10\0", 4), kBitsAllocated("\x28\0\0\1", 4), kBitsStored("\x28\0\1\1", 4),
    kHighBit("\x28\0\2\1", 4);

// A header that does not match its frame: GDCM would read or write beyond the pixels.
TEST(IngestDicom, AFrameThatIsNotTheHeadersIsAnError) {
  for (const DicomCodec codec :
       {DicomCodec::kRle, DicomCodec::kJpegLossless, DicomCodec::kJpegLs, DicomCodec::kJpeg2000}) {
    const ForeignFiles files;
    const ForeignVolume volume = randomVolume({16, 16, 1}, VoxelType::u16, 130);
    const auto path = files.write("a.dcm", dicomFile(specOf(volume, 0, 1, {})));
    compressDicom(path, codec);
    const std::string whole = bytesOf(path);
    const auto expect = [&](const std::string& changed, const std::string& says) {
      const auto source = openSource(files.write("b.dcm", changed));
      try {
        readWhole(*source);
        ADD_FAILURE() << "codec " << static_cast<int>(codec) << " " << says;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kFormat);
        EXPECT_NE(std::string(error.what()).find("b.dcm: frame 1: "), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
      }
    };
    const bool runs = codec == DicomCodec::kRle;
    expect(withShort(whole, kRows, 8), runs ? "256 pixels, but the header says 16 x 8" : "16 x 16 of 16 bits");
    expect(withShort(whole, kRows, 32), runs ? "256 pixels" : "header says 16 x 32");
    for (const int bits : {8, 32}) {
      std::string changed = withShort(withShort(whole, kBitsAllocated, bits), kBitsStored, bits);
      expect(withShort(changed, kHighBit, bits - 1), runs ? "2 run-length segments" : "of 16 bits");
    }
    files.write("c.dcm", withShort(withShort(whole, kBitsStored, 12), kHighBit, 15));
    expectRefused(files.directory() / "c.dcm", ErrorCode::kUnsupported, "12 bits stored up to bit 15");
  }
}

// Elements unknown to earlier copies of a file, or nested: an icon in fragments, and groups with the type UN.
TEST(IngestDicom, NestedElementsOfAnyKindArePassedOrRead) {
  const auto implicit = [](const std::string& tag, const std::string& value) {
    return tag + static_cast<char>(value.size()) + std::string(3, '\0') + value;
  };
  const std::string item("\xfe\xff\0\xe0", 4);
  const ForeignFiles files;
  DicomSpec spec;
  spec.pixel_bytes = std::string(40, '\1');
  spec.spacing = "";
  const std::string fragments = std::string("\xe0\x7f\x10\0OB\0\0\xff\xff\xff\xff", 12) + implicit(item, "") +
                                implicit(item, "fragment") + std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  const std::string icon = implicit(std::string("\x88\0\0\2SQ\0\0", 8), implicit(item, fragments));
  const std::string spacing = implicit(std::string("\x28\0\x30\0", 4), "0.5\\0.25");
  const std::string measures = implicit(std::string("\x28\0\x10\x91", 4), implicit(item, spacing));
  const std::string groups = implicit(std::string("\0\x52\x29\x92UN\0\0", 8), implicit(item, measures));
  spec.elements = icon + groups;
  EXPECT_EQ(openSource(files.write("a.dcm", dicomFile(spec)))->info().geometry.spacing().x, 0.25);
}

// Known: elements of illegal representations have 2 bytes of length, those of future ones 4 bytes (PS3.5, 7.1.2).
TEST(IngestDicom, UnknownRepresentationsArePassedOver) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 1}, VoxelType::i16, 12);
  DicomSpec spec = specOf(volume, 0, 1, DicomSyntax::kExplicitLittle);
  spec.elements = std::string("\x11\0\x10\0??\4\0abcd", 12) + std::string("\x11\0\x11\0XY\0\0\4\0\0\0abcd", 16);
  expectReadsBack(volume, files.write("a.dcm", dicomFile(spec)), 13);
}

// Known: a file has one frame at least.
TEST(IngestDicom, NoFramesAreOneFrame) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 1}, VoxelType::i16, 14);
  DicomSpec spec = specOf(volume, 0, 1, DicomSyntax::kExplicitLittle);
  spec.frames = 0;
  expectReadsBack(volume, files.write("a.dcm", dicomFile(spec)), 15);
}

// Twelve of sixteen bits; the other bits contain data outside the image.
TEST(IngestDicom, OnlyStoredBitsAreValues) {
  const ForeignFiles files;
  for (const bool is_signed : {false, true}) {
    for (const int high_bit : {11, 15}) {
      DicomSpec spec;
      spec.columns = 256, spec.rows = 16;
      spec.bits_stored = 12, spec.high_bit = high_bit, spec.is_signed = is_signed;
      std::vector<std::int32_t> expected;
      for (int i = 0; i < 4096; ++i) {
        const int bits = high_bit == 11 ? i | (i % 16) << 12 : i << 4 | i % 16;
        spec.pixel_bytes += static_cast<char>(bits & 255);
        spec.pixel_bytes += static_cast<char>(bits >> 8);
        expected.push_back(is_signed && i >= 2048 ? i - 4096 : i);
      }
      const auto source = openSource(files.write("a.dcm", dicomFile(spec)));
      const std::vector<std::byte> found = readWhole(*source);
      for (std::size_t i = 0; i < expected.size(); ++i) {
        std::int16_t value = 0;
        std::memcpy(&value, &found[2 * i], 2);
        ASSERT_EQ(value, expected[i]) << is_signed << " " << high_bit;
      }
    }
  }
}

// Returns the type and the value of a pixel after rescaling.
std::pair<VoxelType, double> rescaled(DicomSpec spec, std::int64_t stored) {
  const ForeignFiles files;
  spec.columns = spec.rows = 1;
  for (int i = 0; i < spec.bits_allocated; i += 8) spec.pixel_bytes += static_cast<char>(stored >> i & 255);
  const auto source = openSource(files.write("a.dcm", dicomFile(spec)));
  const std::vector<std::byte> bytes = readWhole(*source);
  double out = 0;
  withVoxelType(source->info().type, [&]<class T>(std::type_identity<T>) {
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    out = static_cast<double>(value);
  });
  return {source->info().type, out};
}

TEST(IngestDicom, RescalingTakesTheNarrowestExactType) {
  DicomSpec spec;
  using Answer = std::pair<VoxelType, double>;
  EXPECT_EQ(rescaled(spec, -5), (Answer{VoxelType::i16, -5}));
  spec.intercept = "-1024", spec.slope = "1";
  EXPECT_EQ(rescaled(spec, 1000), (Answer{VoxelType::i16, -24}));
  EXPECT_EQ(rescaled(spec, -32768), (Answer{VoxelType::f32, -33792}));
  spec.is_signed = false;
  EXPECT_EQ(rescaled(spec, 1000), (Answer{VoxelType::i16, -24}));
  EXPECT_EQ(rescaled(spec, 40000), (Answer{VoxelType::u16, 38976}));
  EXPECT_EQ(rescaled(spec, 33791), (Answer{VoxelType::i16, 32767}));
  spec.bits_stored = 12;
  EXPECT_EQ(rescaled(spec, 4095), (Answer{VoxelType::i16, 3071}));
  spec.intercept = "-0.5";
  EXPECT_EQ(rescaled(spec, 7), (Answer{VoxelType::f32, 6.5}));
  spec.intercept = "-1024", spec.slope = "0.1";
  EXPECT_EQ(rescaled(spec, 4000), (Answer{VoxelType::f32, static_cast<double>(static_cast<float>(4000 * 0.1 - 1024))}));
  // Floats of this size have steps of 64.
  spec.intercept = "1000000000", spec.slope = "0.5";
  EXPECT_EQ(rescaled(spec, 3), (Answer{VoxelType::f64, 1000000001.5}));
  spec = {}, spec.bits_allocated = spec.bits_stored = 32, spec.intercept = "1";
  EXPECT_EQ(rescaled(spec, 2147483647), (Answer{VoxelType::f64, 2147483648.0}));
  spec = {}, spec.bits_allocated = spec.bits_stored = 8, spec.is_signed = false, spec.intercept = "-10";
  EXPECT_EQ(rescaled(spec, 3), (Answer{VoxelType::i16, -7}));
  spec.intercept = "0", spec.slope = "1.0", spec.photometric = "MONOCHROME1";
  EXPECT_EQ(rescaled(spec, 3), (Answer{VoxelType::u8, 3}));
}

// In PET, each slice has a slope of its own.
TEST(IngestDicom, EachSliceHasItsOwnSlope) {
  const ForeignFiles files;
  for (int z = 0; z < 3; ++z) {
    DicomSpec spec;
    spec.columns = spec.rows = 1, spec.pixel_bytes = std::string("\x64\0", 2);
    spec.position = "0\\0\\" + std::to_string(z), spec.slope = std::to_string(z + 1) + ".5", spec.intercept = "0";
    files.write("s" + std::to_string(z), dicomFile(spec));
  }
  const std::vector<std::byte> bytes = readWhole(*openSource(files.directory()));
  for (std::size_t z = 0; z < 3; ++z) {
    float value = 0;
    std::memcpy(&value, &bytes[4 * z], 4);
    EXPECT_EQ(value, 100 * (static_cast<float>(z) + 1.5f));
  }
}

// A slice may have more stored bits than the first slice.
TEST(IngestDicom, TheTypeHoldsTheValuesOfAllSlices) {
  const ForeignFiles files;
  DicomSpec spec;
  spec.columns = spec.rows = 1;
  spec.is_signed = false, spec.intercept = "-1024", spec.slope = "1";
  spec.bits_stored = 12, spec.pixel_bytes = std::string("\1\0", 2);
  files.write("a", dicomFile(spec));
  spec.bits_stored = 16, spec.pixel_bytes = std::string("\x60\xea", 2), spec.position = "0\\0\\1";  // 60000
  files.write("b", dicomFile(spec));
  const auto source = openSource(files.directory());
  EXPECT_EQ(source->info().type, VoxelType::f32);
  const std::vector<std::byte> bytes = readWhole(*source);
  float values[2];
  std::memcpy(values, bytes.data(), sizeof(values));
  EXPECT_EQ(values[0], -1023);
  EXPECT_EQ(values[1], 58976);
}

// PS3.3 C.8.8.3.2: offsets from the first frame, or positions along the axis; and a scaling of doses.
TEST(IngestDicom, DosesAreScaledAndLieWhereTheirOffsetsSay) {
  for (const char* offsets : {"0\\3", "-100\\-97"}) {
    const ForeignFiles files;
    DicomSpec spec;
    spec.modality = "RTDOSE", spec.columns = spec.rows = 1, spec.frames = 2;
    spec.position = "0\\0\\-100", spec.frame_offsets = offsets, spec.dose_scaling = "0.5";
    spec.is_signed = false, spec.pixel_bytes = std::string("\4\0\6\0", 4);
    const auto source = openSource(files.write("a.dcm", dicomFile(spec)));
    EXPECT_EQ(source->info().geometry.worldOf({0, 0, 0}), glm::dvec3(0, 0, -100)) << offsets;
    EXPECT_EQ(source->info().geometry.worldOf({0, 0, 1}), glm::dvec3(0, 0, -97)) << offsets;
    const std::vector<std::byte> bytes = readWhole(*source);
    float values[2];
    ASSERT_EQ(bytes.size(), sizeof(values));
    std::memcpy(values, bytes.data(), sizeof(values));
    EXPECT_EQ(values[0], 2);
    EXPECT_EQ(values[1], 3);
  }
}

std::string shortsOf(const std::vector<int>& numbers, DicomSyntax syntax) {
  std::string out;
  for (const int number : numbers) {
    const char high = static_cast<char>(number >> 8), low = static_cast<char>(number);
    out += syntax == DicomSyntax::kExplicitBig ? std::string{high, low} : std::string{low, high};
  }
  return out;
}

// Known from PS3.3, C.11.1: entry i stands for the stored value `first` + i, and the end entries for all beyond.
TEST(IngestDicom, TableOfTheModality_mapsStoredValues) {
  for (const DicomSyntax syntax :
       {DicomSyntax::kExplicitLittle, DicomSyntax::kImplicitLittle, DicomSyntax::kExplicitBig}) {
    const ForeignFiles files;
    DicomSpec spec;
    spec.syntax = syntax;
    spec.rows = 1;
    spec.pixel_bytes = shortsOf({-1000, -2, -1, 0, 1000}, syntax);
    const auto voxels = [&](const std::string& descriptor, const std::string& data) {
      spec.lut_descriptor = descriptor, spec.lut_data = data;
      const auto source = openSource(files.write("a.dcm", dicomFile(spec)));
      std::vector<std::byte> bytes = readWhole(*source);
      if (source->info().type != VoxelType::u16) return std::vector<int>{static_cast<int>(bytes.size())};
      std::vector<std::uint16_t> wide(bytes.size() / 2);
      std::memcpy(wide.data(), bytes.data(), bytes.size());
      return std::vector<int>(wide.begin(), wide.end());
    };
    EXPECT_EQ(voxels(shortsOf({3, -2, 16}, syntax), shortsOf({7, 40000, 9}, syntax)),
              (std::vector<int>{7, 7, 40000, 9, 9}));
    // 65536 entries are written as 0.
    std::vector<int> squares(65536);
    for (int i = 0; i < 65536; ++i) squares[static_cast<std::size_t>(i)] = i % 251;
    EXPECT_EQ(voxels(shortsOf({0, -32768, 16}, syntax), shortsOf(squares, syntax)),
              (std::vector<int>{31768 % 251, 32766 % 251, 32767 % 251, 32768 % 251, 33768 % 251}));
    EXPECT_EQ(voxels(shortsOf({2, -1, 8}, syntax), shortsOf({7, 9}, syntax)), std::vector<int>{5}) << "bytes";
    EXPECT_EQ(readWhole(*openSource(files.directory() / "a.dcm")),
              (std::vector<std::byte>{std::byte{7}, std::byte{7}, std::byte{7}, std::byte{9}, std::byte{9}}));
  }
}

TEST(IngestDicom, TableThatOtherSlicesLack_isRefused) {
  const ForeignFiles files;
  for (int z = 0; z < 3; ++z) {
    DicomSpec spec;
    spec.pixel_bytes = std::string(40, '\1');
    spec.position = "0\\0\\" + std::to_string(z);
    if (z == 1) spec.lut_descriptor = std::string("\2\0\0\0\20\0", 6), spec.lut_data = "abcd";
    files.write("s" + std::to_string(z), dicomFile(spec));
  }
  expectRefused(files.directory(), ErrorCode::kFormat, "maps its values by a lookup table");
}

// Known: a word's second byte is the first pixel. Frames of 9 pixels begin inside words.
TEST(IngestDicom, BytesInBigEndianWords_readBack) {
  const ForeignVolume volume = randomVolume({3, 3, 4}, VoxelType::u8, 77);
  const ForeignFiles files;
  DicomSpec spec = specOf(volume, 0, 4, DicomSyntax::kExplicitBig);
  spec.in_words = true;
  for (std::size_t i = 0; i < spec.pixel_bytes.size(); i += 2) std::swap(spec.pixel_bytes[i], spec.pixel_bytes[i + 1]);
  expectReadsBack(volume, files.write("a.dcm", dicomFile(spec)), 78);
}

TEST(IngestDicom, WhatIsNotReadIsRefusedByName) {
  const ForeignFiles files;
  const auto expect = [&](const DicomSpec& spec, ErrorCode code, const std::string& says) {
    expectRefused(files.write("a.dcm", dicomFile(spec)), code, says);
  };
  DicomSpec spec;
  spec.pixel_bytes = std::string(120, '\0');
  DicomSpec s = spec;
  s.samples = 3, s.photometric = "RGB";
  expect(s, ErrorCode::kUnsupported, "3 samples a pixel ('RGB')");
  s = spec, s.photometric = "PALETTE COLOR";
  expect(s, ErrorCode::kUnsupported, "palette");
  s = spec, s.bits_allocated = 12, s.bits_stored = 12;
  expect(s, ErrorCode::kUnsupported, "12 bits");
  s = spec, s.lut_descriptor = "xx";
  expect(s, ErrorCode::kFormat, "(0028,3002): expected 3 numbers (found 1)");
  s = spec, s.lut_descriptor = std::string("\4\0\0\0\7\0", 6), s.lut_data = "abcd";
  expect(s, ErrorCode::kFormat, "(0028,3002): expected 8 to 16 bits an entry (found 7)");
  s = spec, s.lut_descriptor = std::string("\4\0\0\0\14\0", 6), s.lut_data = "abcd";
  expect(s, ErrorCode::kFormat, "(0028,3006): expected 4 entries (found 4 bytes)");
  s = spec, s.pixels = false;
  expect(s, ErrorCode::kUnsupported, "no pixel data");
  s = spec, s.rows = 0;
  expect(s, ErrorCode::kFormat, "0 rows");
  s = spec, s.rows = 60;
  expect(s, ErrorCode::kFormat, "there are 120 bytes");
  s = spec, s.frames = 4;
  expect(s, ErrorCode::kFormat, "there are 120 bytes");
  s = spec, s.frames = 1'000'001;
  expect(s, ErrorCode::kUnsupported, "at most 1000000 frames are read (found 1000001)");
  s = spec, s.slope = "2,5";
  expect(s, ErrorCode::kFormat, "(0028,1053): '2,5' is not a number");
  for (const char* garbage : {"nan", "inf", "1e400", "1\\2", "0x10"}) {
    s = spec, s.slope = garbage;
    expect(s, ErrorCode::kFormat, "is not a number");
    s = spec, s.intercept = garbage;
    expect(s, ErrorCode::kFormat, "is not a number");
  }
  for (const char* extreme : {"1e300", "-1e36", "1e-300"}) {
    s = spec, s.slope = extreme;
    expect(s, ErrorCode::kFormat, "take values beyond what a float can hold");
  }
  s = spec, s.intercept = "1e300";
  expect(s, ErrorCode::kFormat, "intercept 1e+300 take values beyond what a float can hold");
  s = spec, s.bits_stored = 17;
  expect(s, ErrorCode::kFormat, "17 bits stored");
  files.write("a.dcm", std::string(128, '\0') + "DICM");
  expectRefused(files.directory() / "a.dcm", ErrorCode::kUnsupported, "no pixel data");
}

TEST(IngestDicom, EveryTruncationIsAnErrorOrTheData) {
  const ForeignVolume volume = randomVolume({32, 20, 2}, VoxelType::u16, 20);
  for (const int codec : {-2, -1, 0, 1, 2, 3}) {
    const ForeignFiles files;
    const DicomSyntax syntax = codec == -2 ? DicomSyntax::kDeflated : DicomSyntax::kExplicitLittle;
    const auto path = files.write("a.dcm", dicomFile(specOf(volume, 0, 2, syntax)));
    if (codec >= 0) compressDicom(path, static_cast<DicomCodec>(codec));
    const std::string whole = bytesOf(path);
    testing::internal::CaptureStderr();
    std::size_t wrong = 0;
    for (std::size_t length = 0; length < whole.size(); ++length) {
      files.write("a.dcm", whole.substr(0, length));
      try {
        wrong += readWhole(*openSource(path)) == volume.voxels ? 0 : 1;
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("a.dcm"), std::string::npos) << error.what();
      }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(wrong, 0u) << "of " << whole.size() << " cuts, codec " << codec;
  }
}

// Known: GDCM and its codecs run in a process of their own, so that damage inside a frame is other values or one error.
TEST(IngestDicom, FlippedBitsOfFrames_areOneErrorOrValues) {
  const ForeignVolume volume = randomVolume({40, 32, 2}, VoxelType::u16, 23);
  const ForeignFiles files;
  std::mt19937_64 random(24);
  for (const DicomCodec codec :
       {DicomCodec::kRle, DicomCodec::kJpegLossless, DicomCodec::kJpegLs, DicomCodec::kJpeg2000}) {
    const auto path = files.write("a.dcm", dicomFile(specOf(volume, 0, 2, {})));
    compressDicom(path, codec);
    const std::string whole = bytesOf(path);
    const std::size_t pixels = whole.find(std::string("\xe0\x7f\x10\0OB", 6));
    ASSERT_NE(pixels, std::string::npos);
    for (int i = 0; i < casesOf(40, 15); ++i) {
      std::string damaged = whole;
      for (int flips = 0; flips < 1 + i % 8; ++flips)
        damaged[pixels + 12 + random() % (whole.size() - pixels - 12)] ^= static_cast<char>(1u << (random() % 8));
      files.write("a.dcm", damaged);
      try {
        readWhole(*openSource(path));
      } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        EXPECT_NE(text.find("a.dcm"), std::string::npos) << text;
        if (text.find("its process") != std::string::npos) RecordProperty("crash", text);
      }
    }
  }
}

// Ends the processes that this one started and that run `program`. Returns their number.
int killChildren(const std::string& program) {
  int out = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string pid = entry.path().filename().string();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    // The name of a process has 15 characters at most, in parentheses; then follow its state and its parent.
    std::ifstream stat(entry.path() / "stat");
    std::string number, name, state;
    int parent = 0;
    stat >> number >> name >> state >> parent;
    if (parent != ::getpid() || name != "(" + program.substr(0, 15) + ")") continue;
    ::kill(std::stoi(pid), SIGKILL);
    ++out;
  }
  return out;
}

// Known: the worker is killed between two slices, as by a system without memory.
TEST(IngestDicom, AWorkerThatIsKilled_isAnErrorOfItsSliceAlone) {
  const ForeignVolume volume = randomVolume({64, 48, 3}, VoxelType::u16, 25);
  const ForeignFiles files;
  writeSlices(files, volume);
  for (int i = 1; i <= 3; ++i) compressDicom(files.directory() / ("s" + std::to_string(i)), DicomCodec::kJpegLs);
  const auto source = openSource(files.directory());
  const auto read = [&](std::int64_t z) {
    const VoxelBox box = {{0, 0, z}, {64, 48, z + 1}};
    std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * 2);
    source->read(box, out);
    EXPECT_TRUE(out == volume.box(box)) << z;
  };
  read(0);
  ASSERT_EQ(killChildren("kiln_gdcm_reader"), 1);
  try {
    read(1);
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.substr(text.rfind('/') + 1), "s2: frame 1: GDCM failed: its process was ended by signal 9");
  }
  read(1);
  read(2);
}

// Flips bits of the whole uncompressed file, and of the headers of a compressed file.
TEST(IngestDicom, FlippedBitsNeverCrash) {
  const ForeignVolume volume = randomVolume({16, 12, 2}, VoxelType::u16, 21);
  const ForeignFiles files;
  DicomSpec spec = specOf(volume, 0, 2, {});
  spec.frame_positions = {"0\\0\\0", "0\\0\\1"};
  const auto path = files.write("a.dcm", dicomFile(spec));
  const std::string plain = bytesOf(path);
  expectBitFlipsAreHarmless(files, "a.dcm", plain, plain.size(), path, 21);
  spec.syntax = DicomSyntax::kDeflated;
  const std::string deflated = dicomFile(spec);
  expectBitFlipsAreHarmless(files, "a.dcm", deflated, deflated.size(), path, 22);
  compressDicom(path, DicomCodec::kRle);
  const std::string packed = bytesOf(path);
  std::mt19937_64 random(22);
  int errors = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = packed;
    damaged[random() % damaged.size()] ^= static_cast<char>(1u << (random() % 8));
    files.write("a.dcm", damaged);
    try {
      openSource(path);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("a.dcm"), std::string::npos) << error.what();
      ++errors;
    }
  }
  EXPECT_GT(errors, 0);
}

// Every slice of the directory is a slice of the head, whose stored value is the rescaled DICOM value plus 1024; a
// search finds the slice's index.
TEST(IngestDicom, TheRealSlicesAreTheHeads) {
  const fs::path series = realData("dicom"), head = realData("vhm_head_512x512x245_i16le.nrrd");
  if (series.empty() || head.empty()) GTEST_SKIP() << "../shared/data is not here";
  const auto dicom = openSource(series), whole = openSource(head);
  ASSERT_EQ(dicom->info().geometry.dims, (Extent3{512, 512, 40}));
  ASSERT_EQ(dicom->info().type, VoxelType::i16);
  EXPECT_EQ(dicom->info().geometry.frame, PatientFrame::kLps);
  EXPECT_EQ(dicom->info().geometry.unit, "mm");
  EXPECT_EQ(dicom->info().geometry.worldOf({1, 2, 3}), glm::dvec3(1, 2, 1102));
  const std::size_t slice = 512 * 512;
  std::vector<std::int16_t> found(slice * 40), all(slice * 245);
  dicom->read(boxOf({512, 512, 40}), std::as_writable_bytes(std::span(found)));
  whole->read(boxOf({512, 512, 245}), std::as_writable_bytes(std::span(all)));
  for (std::int16_t& value : found) value = static_cast<std::int16_t>(value + 1024);
  std::ptrdiff_t at = -1;
  for (std::size_t z = 0; z + 40 <= 245 && at < 0; ++z) {
    if (std::equal(found.begin(), found.end(), all.begin() + static_cast<std::ptrdiff_t>(z * slice)))
      at = static_cast<std::ptrdiff_t>(z);
  }
  EXPECT_GE(at, 0) << "the forty slices are not forty of the head's that follow each other";
  RecordProperty("first_slice", static_cast<int>(at));
}

}  // namespace
}  // namespace kiln::test
