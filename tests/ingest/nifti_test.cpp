// NIfTI and ANALYZE. Known because the files are written here byte by byte from the offsets of nifti1.h and nifti2.h,
// with voxel i a known function of i. Real files are also read by a second, simpler decoder (zlib's gzread).
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "base/error.h"
#include "ingest/open_source.h"
#include "ingest/source/formats.h"
#include "support/files/foreign_files.h"
#include "support/files/nifti_files.h"

namespace kiln {
namespace {
namespace fs = std::filesystem;
using test::Bytes;
using test::NiftiHeader;

constexpr int kVoxels = 60;
struct Type {
  int code, bits;
  VoxelType type;
};
constexpr Type kTypes[] = {{2, 8, VoxelType::u8},     {4, 16, VoxelType::i16},  {8, 32, VoxelType::i32},
                           {16, 32, VoxelType::f32},  {64, 64, VoxelType::f64}, {256, 8, VoxelType::i8},
                           {512, 16, VoxelType::u16}, {768, 32, VoxelType::u32}};

// Distinct at each voxel; negative for signed types, and more than a byte for wider types.
double valueAt(int i, const Type& t) {
  const double sign = t.type == VoxelType::u8 || t.type == VoxelType::u16 || t.type == VoxelType::u32 ? 1 : -1;
  return sign * i * (t.bits == 8 ? 2 : t.bits == 16 ? 531 : t.type == VoxelType::f32 ? 70001 : 7000001);
}

Bytes voxelsOf(const Type& t, bool big_endian) {
  Bytes out;
  for (int i = 0; i < kVoxels; ++i) test::appendValue(out, valueAt(i, t), t.code, big_endian);
  return out;
}

std::vector<double> readAll(VolumeSource& source) {
  const VolumeGeometry& g = source.info().geometry;
  std::vector<std::byte> raw(static_cast<std::size_t>(g.dims.count()) * sizeOf(source.info().type));
  source.read(boxOf(g.dims), raw);
  source.finish();
  std::vector<double> out;
  withVoxelType(source.info().type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t at = 0; at < raw.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, raw.data() + at, sizeof(T));
      out.push_back(static_cast<double>(value));
    }
  });
  return out;
}

class Nifti : public ::testing::Test {
 protected:
  std::unique_ptr<VolumeSource> open(const NiftiHeader& header, const Bytes& voxels = Bytes(kVoxels)) {
    test::writeBytes(directory_ / "a.nii", test::niftiFile(header, voxels));
    return openNifti(directory_ / "a.nii", {});
  }
  glm::dmat4 affine(const NiftiHeader& header) { return open(header)->info().geometry.world_from_index; }
  void expectRefusal(const NiftiHeader& header, ErrorCode code, const std::string& says) {
    test::expectError([&] { open(header); }, code, says);
  }
  void expectContainers(const Type& t, bool big, bool second);
  test::ScratchDirectory directory_;
};

// Expects the values back from a single file and a pair, raw and in gzip, of either version.
void Nifti::expectContainers(const Type& t, bool big, bool second) {
  NiftiHeader h;
  h.datatype = t.code, h.bitpix = t.bits, h.big_endian = big;
  if (second) h.sizeof_hdr = 540, h.magic = "n+2";
  h.vox_offset = static_cast<float>(h.sizeof_hdr + 20);  // an extension of 16 bytes lies before
  const Bytes voxels = voxelsOf(t, big), whole = test::niftiFile(h, voxels);
  test::writeBytes(directory_ / "a.nii", whole);
  test::writeBytes(directory_ / "b.nii.gz", test::gzipped(whole));
  h.vox_offset = 0, h.magic = second ? "ni2" : "ni1";
  test::writeBytes(directory_ / "c.hdr", test::niftiHeader(h));
  test::writeBytes(directory_ / "c.img", voxels);
  test::writeBytes(directory_ / "d.hdr.gz", test::gzipped(test::niftiHeader(h)));
  test::writeBytes(directory_ / "d.img.gz", test::gzipped(voxels));
  test::writeBytes(directory_ / "E.HDR", test::niftiHeader(h));
  test::writeBytes(directory_ / "E.IMG", voxels);
  test::writeBytes(directory_ / "f.hdr", test::niftiHeader(h));
  test::writeBytes(directory_ / "G.HDR.gz", test::gzipped(test::niftiHeader(h)));
  test::writeBytes(directory_ / "G.IMG.gz", test::gzipped(voxels));
  test::writeBytes(directory_ / "f.IMG.GZ", test::gzipped(voxels));
  for (const char* name : {"a.nii", "b.nii.gz", "c.hdr", "c.img", "d.hdr.gz", "d.img.gz", "E.HDR", "E.IMG", "f.hdr",
                           "f.IMG.GZ", "G.HDR.gz", "G.IMG.gz"}) {
    const auto source = openSource(directory_ / name);
    EXPECT_EQ(source->info().format, second ? "NIfTI-2" : "NIfTI-1");
    EXPECT_EQ(source->info().type, t.type);
    EXPECT_EQ(source->info().geometry.dims, (Extent3{5, 4, 3}));
    const std::vector<double> values = readAll(*source);
    for (int i = 0; i < kVoxels; ++i)
      ASSERT_EQ(values[static_cast<std::size_t>(i)], valueAt(i, t)) << name << " " << t.code;
  }
}

TEST_F(Nifti, EveryTypeOrderAndContainerGivesTheValuesBack) {
  for (const Type& t : kTypes) {
    for (const bool big : {false, true}) {
      for (const bool second : {false, true}) expectContainers(t, big, second);
    }
  }
}

// The fields of NIfTI-2 have other offsets and types; their meaning is the same.
TEST_F(Nifti, SecondVersionHasTheGeometryOfTheFirst) {
  for (const int code : {1, 2, 3}) {
    NiftiHeader h;
    h.sform_code = code & 1, h.qform_code = code >> 1;
    h.pixdim = {-1, 2, 3, 4};
    h.quatern = {0.5f, 0.25f, 0.125f, 10, 20, 30};
    h.srow = {-2, 0.5f, 0, 90, 0, 3, 0.25f, -126, 0, 0, 4, -72};
    h.scl_slope = 0.5f, h.scl_inter = 3, h.xyzt_units = 3;
    const glm::dmat4 first = affine(h);
    h.sizeof_hdr = 540, h.magic = "n+2", h.vox_offset = 544;
    const auto source = open(h, voxelsOf(kTypes[0], false));
    EXPECT_EQ(source->info().geometry.world_from_index, first);
    EXPECT_EQ(source->info().geometry.unit, "um");
    EXPECT_EQ(source->info().type, VoxelType::f32);
    EXPECT_EQ(readAll(*source)[7], valueAt(7, kTypes[0]) / 2 + 3);
  }
}

// dim[4] counts the times, one volume behind the other.
TEST_F(Nifti, SeriesIsOneVolumeByTime) {
  NiftiHeader h;
  h.dim = {4, 5, 4, 1, 3, 1, 1, 1};
  const Bytes whole = test::niftiFile(h, voxelsOf(kTypes[0], false));
  test::writeBytes(directory_ / "a.nii", whole);
  test::writeBytes(directory_ / "a.nii.gz", test::gzipped(whole));
  for (const char* name : {"a.nii", "a.nii.gz"}) {
    SourceOptions options;
    options.time = 2;
    const auto source = openSource(directory_ / name, options);
    EXPECT_EQ(source->info().format, "NIfTI-1, time 2");
    EXPECT_EQ(readAll(*source)[3], valueAt(43, kTypes[0]));
    EXPECT_TRUE(source->info().notes.empty());
  }
  test::expectRefused(directory_ / "a.nii", ErrorCode::kUsage, "holds 3 times; choose one with --time, from 0 to 2");
}

// ANALYZE has no magic. The fields behind vox_offset mean other things there.
TEST_F(Nifti, AnalyzePairHasSpacingAlone) {
  NiftiHeader h;
  h.magic = "", h.vox_offset = 0, h.pixdim = {0, 2, 3, 4}, h.datatype = 4, h.bitpix = 16;
  h.scl_slope = 5, h.intent_code = 1007, h.sform_code = 1, h.qform_code = 1, h.xyzt_units = 3;
  for (const bool big : {false, true}) {
    h.big_endian = big;
    test::writeBytes(directory_ / "c.hdr", test::niftiHeader(h));
    test::writeBytes(directory_ / "c.img", voxelsOf(kTypes[1], big));
    for (const char* name : {"c.hdr", "c.img"}) {
      const auto source = openSource(directory_ / name);
      EXPECT_EQ(source->info().format, "ANALYZE 7.5");
      EXPECT_EQ(source->info().type, VoxelType::i16);
      EXPECT_EQ(source->info().geometry.worldOf({1, 1, 1}), glm::dvec3(2, 3, 4));
      EXPECT_EQ(source->info().geometry.frame, PatientFrame::kUnknown);
      EXPECT_EQ(readAll(*source)[9], valueAt(9, kTypes[1]));
      ASSERT_EQ(source->info().notes.size(), 1u);
      EXPECT_NE(source->info().notes[0].find("no directions"), std::string::npos);
    }
  }
}

TEST_F(Nifti, MissingHalfOfAPairIsNamed) {
  const auto expectMissing = [&](const char* name, const std::string& says) {
    test::expectRefused(directory_ / name, ErrorCode::kNotFound, says);
  };
  test::writeBytes(directory_ / "only.img", Bytes(kVoxels));
  expectMissing("only.img", "the header of this image, 'only.hdr', is missing");
  for (const char* magic : {"ni1", ""}) {
    NiftiHeader h;
    h.magic = magic, h.vox_offset = 0;
    test::writeBytes(directory_ / "alone.hdr", test::niftiHeader(h));
    expectMissing("alone.hdr", "the image of this pair, 'alone.img', is missing");
  }
}

// The .img has no magic of its own: beside a NIfTI header it is half of a pair, alone it is raw.
TEST_F(Nifti, EitherHalfOfAPairOpensIt) {
  NiftiHeader h;
  h.vox_offset = 0, h.magic = "ni1";
  const Bytes voxels = voxelsOf(kTypes[0], false);
  test::writeBytes(directory_ / "c.hdr", test::niftiHeader(h));
  test::writeBytes(directory_ / "c.img", voxels);
  test::writeBytes(directory_ / "d.hdr.gz", test::gzipped(test::niftiHeader(h)));
  test::writeBytes(directory_ / "d.img.gz", test::gzipped(voxels));
  for (const char* name : {"c.hdr", "c.img", "d.hdr.gz", "d.img.gz"}) {
    const auto source = openSource(directory_ / name);
    EXPECT_EQ(source->info().format, "NIfTI-1") << name;
    EXPECT_EQ(readAll(*source)[7], valueAt(7, kTypes[0])) << name;
  }
  test::writeBytes(directory_ / "e.img", voxels);
  EXPECT_THROW(openSource(directory_ / "e.img"), Error);
  SourceOptions options;
  options.dims = Extent3{5, 4, 3}, options.type = VoxelType::u8;
  EXPECT_EQ(openSource(directory_ / "e.img", options)->info().format, "raw");
  EXPECT_EQ(openSource(directory_ / "c.img", options)->info().format, "raw");
}

TEST_F(Nifti, PixdimAloneScalesAndKnowsNoPatient) {
  NiftiHeader h;
  h.pixdim = {0, 2, 3, -4};
  h.xyzt_units = 3 | 8;
  const auto source = open(h);
  const VolumeGeometry& g = source->info().geometry;
  EXPECT_EQ(g.worldOf({1, 1, 1}), glm::dvec3(2, 3, 4));
  EXPECT_EQ(g.frame, PatientFrame::kUnknown);
  EXPECT_EQ(g.unit, "um");
  SourceOptions options;
  options.spacing = glm::dvec3(7, 8, 9);
  EXPECT_EQ(openNifti(directory_ / "a.nii", options)->info().geometry.worldOf({1, 1, 1}), glm::dvec3(7, 8, 9));
}

TEST_F(Nifti, SformIsTheMatrixAndComesBeforeQform) {
  NiftiHeader h;
  h.sform_code = 1, h.qform_code = 1;
  h.srow = {-2, 0.5f, 0, 90, 0, 3, 0.25f, -126, 0, 0, 4, -72};
  const auto source = open(h);
  EXPECT_EQ(source->info().geometry.frame, PatientFrame::kRas);
  EXPECT_EQ(source->info().geometry.unit, "mm");
  EXPECT_EQ(source->info().geometry.worldOf({1, 2, 3}), glm::dvec3(89, -126 + 6.75, -60));
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  EXPECT_THROW(openNifti(directory_ / "a.nii", options), Error);
}

// Writers without a spacing write 0; writers without an affine leave its code or its rows 0.
TEST_F(Nifti, ImpossibleSpacingOrSform_isReplacedAndNoted) {
  NiftiHeader h;
  h.pixdim = {0, 2, 0, std::numeric_limits<float>::quiet_NaN()};
  auto source = open(h);
  EXPECT_EQ(source->info().geometry.worldOf({1, 1, 1}), glm::dvec3(2, 1, 1));
  ASSERT_EQ(source->info().notes.size(), 2u);
  EXPECT_EQ(source->info().notes[0], "pixdim[2] is 0; a spacing of 1 is taken");
  SourceOptions options;
  options.spacing = glm::dvec3(7, 8, 9);
  EXPECT_TRUE(openNifti(directory_ / "a.nii", options)->info().notes.empty());

  h = {};
  h.sform_code = 1;  // rows are zeros
  source = open(h);
  EXPECT_EQ(source->info().geometry.frame, PatientFrame::kUnknown);
  EXPECT_EQ(source->info().notes, std::vector<std::string>{"its sform is empty; the spacing alone is taken"});
  h.qform_code = 1;
  h.pixdim = {1, 2, 3, 4};
  h.quatern = {0, 0, 0, 10, 20, 30};
  source = open(h);
  EXPECT_EQ(source->info().geometry.frame, PatientFrame::kRas);
  EXPECT_EQ(source->info().geometry.worldOf({1, 1, 1}), glm::dvec3(12, 23, 34));
  EXPECT_EQ(source->info().notes, std::vector<std::string>{"its sform is empty; the qform is taken"});
  h.srow = {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(open(h)->info().notes, std::vector<std::string>{"its sform has no volume; the qform is taken"});
}

// A quarter turn about z takes x to y and y to -x: b = c = 0, d = sin 45°. A half turn about x is b = 1.
TEST_F(Nifti, QformTurnsAndMirrors) {
  NiftiHeader h;
  h.qform_code = 1;
  h.pixdim = {-1, 2, 3, 4};
  h.quatern = {0, 0, static_cast<float>(std::sqrt(0.5)), 10, 20, 30};
  glm::dvec4 p = affine(h) * glm::dvec4(1, 1, 1, 1);
  const double expected[] = {10 - 3, 20 + 2, 30 - 4};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(p[i], expected[i], 1e-6);
  h.pixdim[0] = 1;
  h.quatern = {1, 0, 0, 0, 0, 0};
  p = affine(h) * glm::dvec4(1, 1, 1, 1);
  EXPECT_EQ(p, glm::dvec4(2, -3, -4, 1));
}

TEST_F(Nifti, ScaleIsAppliedInDoubleAndRoundedOnce) {
  for (const Type& t : kTypes) {
    NiftiHeader h;
    h.datatype = t.code, h.bitpix = t.bits, h.scl_slope = 0.1f, h.scl_inter = -7.5f;
    const auto source = open(h, voxelsOf(t, false));
    const bool f64 = (t.bits == 32 && t.code != 16) || t.bits == 64;
    EXPECT_EQ(source->info().type, f64 ? VoxelType::f64 : VoxelType::f32);
    const std::vector<double> values = readAll(*source);
    for (int i = 0; i < kVoxels; ++i) {
      const double stored = t.code == 16 ? static_cast<double>(static_cast<float>(valueAt(i, t))) : valueAt(i, t);
      const double exact = stored * static_cast<double>(0.1f) - 7.5;
      ASSERT_EQ(values[static_cast<std::size_t>(i)], f64 ? exact : static_cast<double>(static_cast<float>(exact)));
    }
  }
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float slope : {0.0f, nan, inf, 1.0f}) {
    NiftiHeader h;
    h.scl_slope = slope, h.scl_inter = slope == 1 ? 0.0f : 5.0f;
    EXPECT_EQ(open(h)->info().type, VoxelType::u8);
  }
}

TEST_F(Nifti, RefusesByName) {
  NiftiHeader h;
  h.sizeof_hdr = 540, h.vox_offset = 544;
  expectRefusal(h, ErrorCode::kFormat, "byte 4: the header has the length of NIfTI-2");
  h = {}, h.magic = "";
  expectRefusal(h, ErrorCode::kUnsupported, "ANALYZE");
  h = {}, h.dim = {4, 5, 4, 3, 12, 1, 1, 1};
  expectRefusal(h, ErrorCode::kUsage, "holds 12 times");
  h = {}, h.dim = {5, 5, 4, 3, 1, 3, 1, 1};
  expectRefusal(h, ErrorCode::kUnsupported, "3 values a voxel");
  h.intent_code = 1007;
  expectRefusal(h, ErrorCode::kUnsupported, "vector data");
  h = {}, h.dim = {2, 5, 4, 1, 1, 1, 1, 1};
  expectRefusal(h, ErrorCode::kUnsupported, "2 dimensions");
  const std::pair<int, const char*> types[] = {{1, "bits"},       {32, "complex"},   {128, "RGB24"},
                                               {1536, "128-bit"}, {1792, "complex"}, {2304, "RGBA32"}};
  for (const auto& [code, says] : types) {
    h = {}, h.datatype = code;
    expectRefusal(h, ErrorCode::kUnsupported, says);
  }
}

TEST_F(Nifti, TrailingDimensionsOfOneAreAVolume) {
  NiftiHeader h;
  h.dim = {7, 5, 4, 3, 1, 1, 1, 1};
  EXPECT_EQ(open(h)->info().geometry.dims.count(), kVoxels);
  h.dim = {5, 5, 4, 3, 0, 0};
  EXPECT_EQ(open(h)->info().geometry.dims.count(), kVoxels);
}

TEST_F(Nifti, HostileNumbersAreFormatErrors) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float offset : {nan, -1.0f, 0.0f, 351.0f, 352.5f, 1e9f, 1e30f, std::numeric_limits<float>::infinity()}) {
    Bytes file = test::niftiFile({}, Bytes(kVoxels));
    std::memcpy(file.data() + 108, &offset, 4);
    test::writeBytes(directory_ / "a.nii", file);
    EXPECT_THROW(openNifti(directory_ / "a.nii", {}), Error) << offset;
  }
  for (const int dim0 : {0, -1, 8, 32767}) {
    NiftiHeader h;
    h.dim[0] = dim0;
    expectRefusal(h, ErrorCode::kFormat, "dim[0]");
  }
  for (const int n : {0, -5}) {
    NiftiHeader h;
    h.dim[2] = n;
    expectRefusal(h, ErrorCode::kFormat, "dim[2]");
  }
  NiftiHeader h;
  h.dim = {3, 32767, 32767, 32767};
  expectRefusal(h, ErrorCode::kFormat, "the header's dimensions need 35181150961663");
  h = {}, h.sform_code = 1, h.srow = {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};  // two axes are equal
  expectRefusal(h, ErrorCode::kFormat, "the three voxel axes do not span space");
  h = {}, h.qform_code = 1, h.quatern[0] = nan;
  expectRefusal(h, ErrorCode::kFormat, "is not a finite number (found nan)");
  h = {}, h.scl_slope = 2, h.scl_inter = nan;
  expectRefusal(h, ErrorCode::kFormat, "byte 116: scl_inter is nan");
  h = {}, h.bitpix = 16;
  expectRefusal(h, ErrorCode::kFormat, "bitpix");
}

NiftiHeader secondVersion() {
  NiftiHeader h;
  h.sizeof_hdr = 540, h.magic = "n+2", h.vox_offset = 544;
  return h;
}

// Each truncated file lacks a voxel, or gzip's own checksum and length at its end.
TEST_F(Nifti, EveryTruncationIsAnError) {
  const Bytes voxels = voxelsOf(kTypes[0], false), first = test::niftiFile({}, voxels);
  for (const Bytes& file : {first, test::gzipped(first), test::niftiFile(secondVersion(), voxels)}) {
    for (std::size_t n = 0; n < file.size(); ++n) {
      test::writeBytes(directory_ / "a.nii", Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(n)));
      EXPECT_THROW(readAll(*openNifti(directory_ / "a.nii", {})), Error) << n;
    }
  }
}

// A volume or an Error, and a volume fits into the file. Every bit of version 1, and every fifth bit of version 2.
TEST_F(Nifti, FlippedHeaderBitsNeverCrash) {
  const std::pair<NiftiHeader, std::size_t> headers[] = {{NiftiHeader(), 1}, {secondVersion(), 5}};
  for (const auto& [header, step] : headers) {
    const Bytes whole = test::niftiFile(header, voxelsOf(kTypes[0], false));
    for (std::size_t bit = 0; bit < static_cast<std::size_t>(header.sizeof_hdr) * 8; bit += step) {
      Bytes file = whole;
      file[bit / 8] = static_cast<std::uint8_t>(file[bit / 8] ^ (1u << (bit % 8)));
      test::writeBytes(directory_ / "a.nii", file);
      try {
        EXPECT_LE(readAll(*openNifti(directory_ / "a.nii", {})).size(), whole.size()) << bit;
      } catch (const Error&) {
      }
    }
  }
}

#ifdef KILN_TEST_DATA_DIR
class RealNifti : public ::testing::TestWithParam<const char*> {};

// The stored values come from gzread at vox_offset, which shares only zlib with the reader.
TEST_P(RealNifti, HoldsTheStoredValuesScaled) {
  const fs::path path = fs::path(KILN_TEST_DATA_DIR) / "nifti" / GetParam();
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not here; see shared/data/README.md";
  gzFile file = gzopen(path.c_str(), "rb");
  Bytes all(64 << 20);
  all.resize(static_cast<std::size_t>(gzread(file, all.data(), static_cast<unsigned>(all.size()))));
  gzclose(file);
  const auto number = [&]<class T>(std::size_t at, T value) {
    return std::memcpy(&value, all.data() + at, sizeof(T)), value;
  };
  ASSERT_EQ(number(0, std::int32_t{}), 348) << "the three files are little-endian";
  const double slope = static_cast<double>(number(112, 0.0f)), intercept = static_cast<double>(number(116, 0.0f));
  const bool scaled = slope != 0 && !(slope == 1 && intercept == 0);
  const int datatype = number(70, std::int16_t{});
  const auto offset = static_cast<std::size_t>(number(108, 0.0f));

  const auto source = openNifti(path, {});
  const std::vector<double> values = readAll(*source);
  ASSERT_EQ(source->info().geometry.dims,
            (Extent3{number(42, std::int16_t{}), number(44, std::int16_t{}), number(46, std::int16_t{})}));
  EXPECT_EQ(source->info().geometry.frame, PatientFrame::kRas);
  ASSERT_TRUE(datatype == 2 || datatype == 4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double stored = datatype == 2 ? all[offset + i] : number(offset + 2 * i, std::int16_t{});
    const double expected = scaled ? static_cast<double>(static_cast<float>(stored * slope + intercept)) : stored;
    ASSERT_EQ(values[i], expected) << i;
  }
  if (std::string(GetParam()).starts_with("CT_AVM")) {
    EXPECT_NEAR(slope, 2.2, 0.05);
  }
}
INSTANTIATE_TEST_SUITE_P(Files, RealNifti,
                         ::testing::Values("ch2.nii.gz", "CT_AVM.nii.gz", "eun_brain_uchar_8.nii.gz"));
#endif

}  // namespace
}  // namespace kiln
