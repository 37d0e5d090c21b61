// Sentences that name the file and the true reason. Known because each test makes the one file that is at fault.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "base/file.h"
#include "support/foreign_files.h"
#include "support/nifti_files.h"
#include "support/procedural.h"
#include "support/text_of.h"
#include "support/tiff_files.h"
#include "support/tool_test.h"
#include "support/vdb_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class Messages : public ToolTest {
 protected:
  Messages() : ToolTest("messages_") {}

  void putNifti(const NiftiHeader& header) const {
    writeBytes(in("a.nii"), niftiFile(header, Bytes(5 * 4 * 3 * static_cast<std::size_t>(header.bitpix) / 8, 1)));
  }
  // A conversion of `input` that is done, with a line for each of the notes, each behind the name of `input`.
  void expectNotes(const std::string& input, const std::vector<std::string>& notes) {
    const std::vector<std::string> lines = done({"convert", in(input), in("o.kiln"), "--overwrite"}).errorLines();
    ASSERT_EQ(lines.size(), notes.size()) << testing::PrintToString(lines);
    for (std::size_t i = 0; i < notes.size(); ++i) EXPECT_EQ(lines[i], "kiln: " + in(input) + ": " + notes[i]);
  }
  void putSlices() const {
    fs::create_directories(in("slices"));
    const ForeignVolume slices = randomVolume({16, 16, 3}, VoxelType::u8, 1);
    for (int z = 0; z < 3; ++z) writeTiff(in("slices/s" + std::to_string(z) + ".tif"), slices, z, z + 1);
  }
};

constexpr const char* kNoSize =
    "the TIFF files do not say how large a voxel is, which is taken to be 1 x 1 x 1; --spacing says otherwise";

TEST_F(Messages, NotesOfASource_NameIt) {
  NiftiHeader header;
  header.pixdim[1] = 0;
  header.sform_code = 1;
  putNifti(header);
  expectNotes("a.nii", {"its sform is empty; the spacing alone is taken", "pixdim[1] is 0; a spacing of 1 is taken"});
  putSlices();
  expectNotes("slices", {kNoSize});
  writeText(in("b.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678123");
  expectNotes("b.nrrd", {"3 bytes behind the header's dimensions not read"});
}

TEST_F(Messages, ImpossibleScaleOfNifti_IsNotedOrRefused) {
  NiftiHeader header;
  for (const float slope : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    header.scl_slope = slope;
    putNifti(header);
    expectNotes("a.nii", {(std::isnan(slope) ? std::string("scl_slope is nan") : "scl_slope is inf") +
                          ", which is no factor; values are taken as they are stored"});
  }
  // 255 times 1e36 is a float, 255 times 2e36 is none.
  header.scl_slope = 1e36f;
  putNifti(header);
  expectNotes("a.nii", {});
  header.scl_slope = 2e36f;
  putNifti(header);
  refused({"convert", in("a.nii"), in("p.kiln")}, 1, in("a.nii") + ": byte 112: scl_slope 2e+36 and scl_inter 0 take");
  header.scl_slope = 3e38f;
  header.datatype = 16, header.bitpix = 32;
  putNifti(header);
  refused({"convert", in("a.nii"), in("p.kiln")}, 1, in("a.nii") + ": byte 112: scl_slope 3e+38 and scl_inter 0 take");
  header.scl_slope = 2;
  header.scl_inter = std::numeric_limits<float>::infinity();
  putNifti(header);
  refused({"convert", in("a.nii"), in("p.kiln")}, 1, in("a.nii") + ": byte 116: scl_inter is inf");
}

TEST_F(Messages, GeometryWithoutAPlace_NamesTheFile) {
  writeText(in("far.nrrd"),
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace dimension: 3\nspace directions: "
            "(1e-9,0,0) (0,1e-9,0) (0,0,1e-9)\nspace origin: (1e30,0,0)\n\n12345678");
  refused({"convert", in("far.nrrd"), in("p.kiln")}, 1, in("far.nrrd") + ": geometry: voxels of 1e-09 x 1e-09 x 1e-09");
  EXPECT_FALSE(fs::exists(in("p.kiln")));
}

TEST_F(Messages, FormatsThatAreNotRead_HaveTheirArticle) {
  writeText(in("p.exr"), std::string("\x76\x2f\x31\x01", 4) + std::string(600, 'x'));
  refused({"convert", in("p.exr"), in("p.kiln")}, 1, ": an OpenEXR file, which is not read");
  writeText(in("p.pdf"), "%PDF" + std::string(600, 'x'));
  refused({"convert", in("p.pdf"), in("p.kiln")}, 1, ": a PDF file, which is not read");
}

TEST_F(Messages, NameOfADataFileThatIsTooLong_IsTheReason) {
  writeText(in("a.nhdr"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: " +
                              std::string(300, 'n') + ".raw\n");
  refused({"convert", in("a.nhdr"), in("p.kiln")}, 1, "cannot be looked at: File name too long");
}

TEST_F(Messages, WhatIsInTheWayOfALock_IsNamedAndStays) {
  const auto expectInTheWay = [&](const std::string& kind) {
    refused({"convert", "phantom:head:16x16x16", in("h.kiln")}, 1,
            in("h.kiln.lock") + ": is " + kind + " in the way of a lock; move it");
    EXPECT_NE(fs::symlink_status(in("h.kiln.lock")).type(), fs::file_type::not_found) << kind;
    EXPECT_FALSE(fs::exists(in("h.kiln")));
    fs::remove(in("h.kiln.lock"));
  };
  fs::create_directory(in("h.kiln.lock"));
  expectInTheWay("a directory");
  ASSERT_EQ(::mkfifo(in("h.kiln.lock").c_str(), 0600), 0);
  expectInTheWay("a pipe");
  fs::create_symlink("nowhere", in("h.kiln.lock"));
  expectInTheWay("a link");
  fs::create_symlink("h.kiln.lock", in("h.kiln.lock"));
  expectInTheWay("a link");
  writeText(in("h.kiln.lock"), "precious");
  refused({"convert", "phantom:head:16x16x16", in("h.kiln")}, 1, "is in the way of a lock, and is none; move it");
  EXPECT_EQ(readTextFile(in("h.kiln.lock")), "precious");
}

// A link to itself cannot be read by anybody.
TEST_F(Messages, OneEntryThatCannotBeRead_IsPassedOverWhereItIsNoSlice) {
  putSlices();
  fs::create_symlink("notes.txt", in("slices/notes.txt"));
  expectNotes("slices", {"passed over 'notes.txt', which cannot be read (looking for it: Too many levels of symbolic "
                         "links) and is not named like the slices",
                         kNoSize});
  fs::create_symlink("s3.tif", in("slices/s3.tif"));
  refused({"convert", in("slices"), in("p.kiln")}, 1,
          in("slices/s3.tif") +
              ": is named like the slices beside it, and cannot be read (looking for it: Too many "
              "levels of symbolic links); mend or remove it");
  fs::remove(in("slices/s3.tif"));
  for (int z = 0; z < 3; ++z) fs::remove(in("slices/s" + std::to_string(z) + ".tif"));
  refused({"convert", in("slices"), in("p.kiln")}, 1, in("slices/notes.txt") + ": looking for it: Too many levels");
}

// OpenVDB would print a warning of its own.
TEST_F(Messages, TreesOfSeveralBuffers_AreRefusedInOneLine) {
  writeVdb(in("a.vdb"), {VdbSpec{}});
  const std::string whole = readTextFile(in("a.vdb"));
  const std::string one("\1\0\0\0", 4), transform = "Map";
  std::size_t map = std::string::npos;
  for (std::size_t at = 0; (at = whole.find(transform, at)) != std::string::npos; ++at) map = at;
  ASSERT_NE(map, std::string::npos);
  int refusals = 0;
  for (std::size_t at = map; at < std::min(map + 400, whole.size()); ++at) {
    if (whole.compare(at, 4, one) != 0) continue;
    std::string changed = whole;
    changed[at] = 2;
    writeText(in("b.vdb"), changed);
    const ToolResult result = runTool({"convert", in("b.vdb"), in("p.kiln"), "--overwrite"});
    EXPECT_EQ(result.err.find("WARN"), std::string::npos) << result.err;
    if (result.err.find("the tree has 2 buffers") == std::string::npos) continue;
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
    ++refusals;
  }
  EXPECT_EQ(refusals, 1);
}

}  // namespace
}  // namespace kiln::test
