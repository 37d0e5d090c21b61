// Errors that name the file and the true reason. Known because each test makes the single faulty file.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/file/file.h"
#include "support/files/foreign_files.h"
#include "support/files/nifti_files.h"
#include "support/files/npy_files.h"
#include "support/files/tiff_files.h"
#include "support/files/vdb_files.h"
#include "support/files/zarr_files.h"
#include "support/system/text_of.h"
#include "support/system/tool_test.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class Messages : public ToolTest {
 protected:
  Messages() : ToolTest("messages_") {}

  void putNifti(const NiftiHeader& header) const {
    writeBytes(in("a.nii"), niftiFile(header, Bytes(5 * 4 * 3 * static_cast<std::size_t>(header.bitpix) / 8, 1)));
  }
  // Converts `input` and expects success with a line for each note, prefixed by the name of `input`. The note on an
  // unknown orientation is left out; it has a test of its own.
  void expectNotes(const std::string& input, const std::vector<std::string>& notes) {
    std::vector<std::string> lines = done({"convert", in(input), in("o.kiln"), "--overwrite"}).errorLines();
    std::erase_if(lines, [](const std::string& line) { return line.find("orientation") != std::string::npos; });
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
    "the TIFF files have no size of a voxel, which is taken to be 1 x 1 x 1; --spacing sets another";

constexpr const char* kNoOrientation =
    "states no orientation; x is taken as left, y as back, z as up; --orient sets another, such as --orient RAS";

// Known because each file either has a patient frame, or has none and was not placed.
TEST_F(Messages, UnknownOrientation_isNotedOnce) {
  const std::string axes = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
  writeText(in("open.nrrd"), axes + "\n12345678");
  writeText(in("placed.nrrd"), axes + "space: right-anterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n" +
                                   "space origin: (0,0,0)\n\n12345678");
  const auto errorOf = [&](std::vector<std::string> command) { return done(command).err; };
  EXPECT_EQ(errorOf({"convert", in("open.nrrd"), in("o.kiln")}),
            "kiln: " + in("open.nrrd") + ": " + kNoOrientation + "\n");
  EXPECT_EQ(errorOf({"convert", in("placed.nrrd"), in("o.kiln"), "--overwrite"}), "");
  EXPECT_NE(errorOf({"render", in("open.nrrd"), "-o", in("p.png"), "--size", "8x8"}).find(kNoOrientation),
            std::string::npos);
  EXPECT_EQ(errorOf({"render", in("open.nrrd"), "-o", in("p.png"), "--size", "8x8"}).find(kNoOrientation),
            std::string::npos);  // of the store that is there
  for (const std::vector<std::string>& placed :
       {std::vector<std::string>{"--orient", "LPS"}, {"--flip", "z"}, {"--up-axis", "y"}}) {
    std::vector<std::string> command = {"convert", in("open.nrrd"), in("o.kiln"), "--overwrite"};
    command.insert(command.end(), placed.begin(), placed.end());
    EXPECT_EQ(errorOf(command).find("orientation"), std::string::npos) << placed[0];
  }
  EXPECT_EQ(errorOf({"convert", "phantom:head:16x16x16", in("o.kiln"), "--overwrite"}), "");
  EXPECT_NE(done({"info", in("open.nrrd")}).out.find(std::string("note         ") + kNoOrientation), std::string::npos);
}

TEST_F(Messages, FolderOfVolumeFiles_namesAFileToConvert) {
  fs::create_directories(in("scans"));
  NiftiHeader header;
  putNifti(header);
  fs::copy_file(in("a.nii"), in("scans/a.nii"));
  const std::string list = "; kiln convert DIRECTORY --list lists all";
  refused({"convert", in("scans"), in("o.kiln")}, 1,
          in("scans") + ": a directory is read as slices of one volume (found a volume file: 'a.nii'); name the file" +
              list);
  fs::copy_file(in("a.nii"), in("scans/b.nii"));
  writeText(in("scans/readme.txt"), "two");
  refused({"convert", in("scans"), in("o.kiln")}, 1,
          in("scans") +
              ": a directory is read as slices of one volume (found 2 volume files: 'a.nii' and 1 more); name "
              "one file at a time" +
              list);
}

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
  refused({"convert", in("a.nhdr"), in("p.kiln")}, 1, "cannot be examined: File name too long");
}

// Known: each header refers to itself, or to a file without voxels.
TEST_F(Messages, DataFileThatHoldsNoVoxels_IsRefused) {
  fs::create_directory(in("folder"));
  ASSERT_EQ(::mkfifo(in("pipe").c_str(), 0600), 0);
  fs::create_symlink("a.nhdr", in("link.nhdr"));
  fs::create_symlink("a.mhd", in("link.mhd"));
  const std::pair<std::string, std::string> cases[] = {{"a", "' is this header itself; name the file that holds"},
                                                       {"./a", "' is this header itself; name the file that holds"},
                                                       {"link", "' is this header itself; name the file that holds"},
                                                       {"folder", "'folder' is a folder; name the regular file"},
                                                       {"pipe", "'pipe' is a pipe or a device; name the regular file"},
                                                       {"/dev/zero", "is a pipe or a device; name the regular file"}};
  for (const auto& [name, says] : cases) {
    const bool header = says.starts_with("' is");
    writeText(in("a.nhdr"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: " + name +
                                (header ? ".nhdr\n" : "\n"));
    refused({"convert", in("a.nhdr"), in("p.kiln")}, 1, says);
    writeText(in("a.mhd"),
              "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
              "ElementDataFile = " +
                  name + (header ? ".mhd\n" : "\n"));
    refused({"convert", in("a.mhd"), in("p.kiln")}, 1, says);
  }
  NiftiHeader header;
  header.magic = "ni1";
  writeBytes(in("n.hdr"), niftiFile(header, Bytes(60, 1)));
  fs::create_symlink("n.hdr", in("n.img"));
  for (const char* name : {"n.hdr", "n.img"})
    refused({"convert", in(name), in("p.kiln")}, 1, "'n.img', the file of its voxels, is this header itself");
}

// Options of volume files are right for most inputs, so a name without a file is the first fault.
TEST_F(Messages, NameWithoutAFile_IsTheReason_BesideOptionsOfFiles) {
  const std::vector<std::vector<std::string>> options = {
      {}, {"--spacing", "1,1,2"}, {"--orient", "LPS"}, {"--channel", "1"}, {"--dims", "2,2,2", "--type", "u8"}};
  for (std::vector<std::string> words : options) {
    words.insert(words.begin(), {"render", in("absent.raw"), "-o", in("a.png")});
    refused(words, 1, in("absent.raw") + ": there is no such file or store; check the name");
  }
}

TEST_F(Messages, LinksThatLeadToOneAnother_AreNamedWithARemedy) {
  fs::create_symlink("b", in("a"));
  fs::create_symlink("a", in("b"));
  const std::vector<std::vector<std::string>> commands = {{"convert", in("a"), in("p.kiln")},
                                                          {"info", in("a")},
                                                          {"render", in("a"), "-o", in("p.png")},
                                                          {"slice", in("a"), "-o", in("p.png")},
                                                          {"compare", in("a"), in("b")},
                                                          {"tf", in("a")},
                                                          {"verify", in("a")},
                                                          {"export", in("a"), in("p.vdb")}};
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command[0]);
    refused(command, 1, "kiln: " + in("a") + ": ");
    refused(command, 1, "Too many levels of symbolic links; the links lead to one another, so mend them or name");
  }
  for (const std::size_t bytes : {252, 255})
    refused(
        {"tf", "ct-bone", "-o", in(std::string(bytes - 4, 'n') + ".png")}, 1,
        fmt::format(".png: its name is {} bytes too long: a temporary name beside it needs 13 more; shorten the name",
                    bytes - 242));
  const std::string name(256, 'n');
  refused({"convert", "phantom:head:16x16x16", in(name)}, 1,
          "File name too long; most file systems allow names of 255");
}

TEST_F(Messages, VolumeInPlaceOfAStoreOrAPicture_IsNamedWithItsCommands) {
  writeText(in("a.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678");
  NiftiHeader header;
  putNifti(header);
  writeVdb(in("a.vdb"), {VdbSpec{}});
  writeTiff(in("a.tif"), randomVolume({16, 16, 1}, VoxelType::u8, 1), 0, 1);
  writeText(in("a.mha"), "ObjectType = Image\nNDims = 3\n");
  writeText(in("a.npy"), npyFile(randomVolume(kFewVoxels, VoxelType::u8, 2)));
  writeText(in("a.h5"), "\x89HDF\r\n\x1a\n");
  writeText(in("a.mrc"), std::string(208, '\0') + "MAP ");
  writeText(in("a.mgh"), "");
  writeText(in("a.am"), "# AmiraMesh BINARY 2.1\n");
  writeText(in("a.vgi"), "{volume1}\n");
  writeText(in("a.vti"), "<VTKFile type=\"ImageData\">");
  writeText(in("a.vtk"), "# vtk DataFile Version 3.0\n");
  const auto commandsFor = [&](const std::string& name) {
    return "; kiln convert " + in(name) + " " + in("a.kiln") + " makes a store of it, kiln render " + in(name) +
           " -o " + in("a.png") + " draws it";
  };
  const std::pair<std::string, std::string> volumes[] = {
      {"a.nrrd", "a NRRD"},     {"a.nii", "a NIfTI"},     {"a.vdb", "an OpenVDB"}, {"a.tif", "a TIFF"},
      {"a.mha", "a MetaImage"}, {"a.npy", "a NumPy"},     {"a.h5", "an HDF5"},     {"a.mrc", "an MRC"},
      {"a.mgh", "an MGH"},      {"a.am", "an AmiraMesh"}, {"a.vgi", "a VGI"},      {"a.vti", "a VTK"},
      {"a.vtk", "a VTK"}};
  for (const auto& [name, format] : volumes) {
    const std::string is = in(name) + ": is " + format + " volume, not ";
    refused({"compare", in(name), in("a.nii")}, 2, is + "a picture" + commandsFor(name));
  }
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"verify", in("a.nrrd")},
                                             {"export", in("a.nrrd"), in("p.vdb")},
                                             {"split", in("a.nrrd"), "-o", in("p##.kiln"), "--parts", "2"}})
    refused(command, 2, in("a.nrrd") + ": is a NRRD volume, not a store" + commandsFor("a.nrrd"));
  refused({"composite", in("a.nrrd"), in("a.nii"), "-o", in("p.png")}, 2, "is a NRRD volume, not a partial image");
  refused({"render", in("none.nii"), "-o", in("p.png")}, 1, in("none.nii") + ": there is no such file or store");
  for (const char* name : {"empty.tif", "empty.h5", "empty.dcm", "empty.png", "empty"}) {
    writeText(in(name), "");
    refused({"convert", in(name), in("p.kiln")}, 1, in(name) + ": is empty");
  }
  writeText(in("a.json"), "{}");
  refused({"verify", in("a.json")}, 1, in("a.json") + ": is a file, not a store");
}

// Known: only a build with the HDF5 library has the program that reads HDF5.
TEST_F(Messages, Hdf5ThatCannotBeRead_NamesTheFileOrTheMissingReader) {
  writeText(in("a.h5"), std::string("\x89HDF\r\n\x1a\n") + std::string(600, 'x'));
#ifdef KILN_TEST_HDF5
  refused({"info", in("a.h5")}, 1, in("a.h5") + ": the HDF5 library cannot read the file; it is damaged, cut, or open");
#else
  refused({"info", in("a.h5")}, 1, "kiln_hdf5_reader: is not beside Kiln's modules, so that HDF5 files cannot be read");
#endif
}

TEST_F(Messages, CameraThatCannotBeUsed_NamesTheJobAndTheKey) {
  done({"convert", "phantom:head:16x16x16", in("h.kiln")});
  const auto expect = [&](const std::string& camera, const std::string& says,
                          const std::vector<std::string>& more = {}) {
    writeText(in("job.json"),
              "{\"kiln\": 1, \"volume\": \"h.kiln\", \"output\": \"o.png\", \"image\": {\"width\": 8, "
              "\"height\": 8}, \"camera\": {" +
                  camera + "}}");
    std::vector<std::string> command = {"render", in("job.json")};
    command.insert(command.end(), more.begin(), more.end());
    refused(command, 2, says);
  };
  const std::string eye = "\"eye\": [0, 0, -99], \"target\": [0, 0, 3], \"up\": ",
                    job = "kiln: " + in("job.json") + ": ";
  expect(eye + "[0, 0, 2]", job + "camera: up runs along the line of sight (found 0, 0, 2); give another up");
  expect(eye + "[0, 0, 0]",
         job + "line 1, camera.up: expected a direction, which the zero vector is not, found [0,0,0]");
  expect(eye + "[0, 1]", job + "line 1, camera.up: expected [x, y, z]");
  expect("\"view\": \"front\", \"up\": [0, 1, 0]", job + "camera: up runs along the line of sight");
  expect(eye + "[0, 1, 0]", "kiln: camera: up runs along the line of sight (found 0, 0, 1)", {"--up", "0,0,1"});
}

TEST_F(Messages, FunctionsThatAreNone_AreNamedWithWhatWasFound) {
  const auto expect = [&](const std::string& text, const std::string& says) {
    writeText(in("itk.txt"), text);
    refused({"tf", in("itk.txt")}, 1, in("itk.txt") + ": " + says);
  };
  expect("1 255 0 0 1 1 1 \"a\"\n2 255 0 0 1 1 \"b\"\n", "line 2: expected a label's index, red, green, blue");
  expect(
      "1 255 0 0 1 1\n",
      "line 1: expected a label's index, red, green, blue (0 to 255), opacity (0 to 1), two of 0 or "
      "1, and its name in quotes; or index, name, red, green, blue, alpha; or index and name (found '1 255 0 0 1 1'); "
      "mend the line");
  expect("-1 255 0 0 1 1 1 \"a\"\n", "line 1: expected a label's index");
  expect("1 1 1 1 1 1 1 \"a\"\n1 1 1 1 1 1 1 \"a\"\n", "line 2: label 1 is given twice; remove one of its lines");
  expect("# nothing\n", "describes no label; write a line for each");
  expect("label red\n", "expected a transfer function in JSON, which begins with { or [, or a label description");
}

// Known: doubles end at 1e308, so squares of these spacings overflow.
TEST_F(Messages, SpacingsBeyondWhatIsComputedWith_AreNamed) {
  const auto nrrd = [&](const std::string& field) {
    writeText(in("a.nrrd"),
              "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n" + field + "encoding: raw\n\n12345678");
    return in("a.nrrd");
  };
  const auto metaImage = [&](const std::string& spacing) {
    writeText(in("a.mha"),
              "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 " +
                  spacing + "\nElementDataFile = LOCAL\n12345678");
    return in("a.mha");
  };
  for (const std::string spacing : {"1e300", "1e-300", "1e101"}) {
    const std::string says = ": geometry: a spacing must be from 1e-100 to 1e+100 world units (found ";
    refused({"convert", nrrd("spacings: 1 1 " + spacing + "\n"), in("p.kiln")}, 1, in("a.nrrd") + says);
    refused({"convert", nrrd("space: RAS\nspace directions: (1,0,0) (0,1,0) (0,0," + spacing + ")\n"), in("p.kiln")}, 1,
            in("a.nrrd") + says);
    refused({"convert", metaImage(spacing), in("p.kiln")}, 1, in("a.mha") + says);
    refused({"convert", nrrd(""), in("p.kiln"), "--spacing", "1,1," + spacing}, 1, in("a.nrrd") + says);
  }
  for (const std::string spacing : {"-1", "nan", "inf"}) {
    refused({"convert", metaImage(spacing), in("p.kiln")}, 1,
            in("a.mha") + ": line 5: ElementSpacing: expected three numbers above 0 (found '1 1 " + spacing + "')");
    refused({"convert", nrrd(""), in("p.kiln"), "--spacing=1,1," + spacing}, 2, "--spacing: expected three");
  }
  refused({"convert", nrrd("spacings: 1 1 inf\n"), in("p.kiln")}, 1, "is not a finite number (found inf)");
}

// Known: a float steps by 64 at 1e9.
TEST_F(Messages, ValuesThatFloatsMerge_AreNoted) {
  const auto put = [&](double offset, double step) {
    std::vector<double> values(8);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = offset + step * static_cast<double>(i);
    std::string bytes(64, '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    writeText(in("a.nrrd"),
              "NRRD0004\ntype: double\ndimension: 3\nsizes: 2 2 2\nendian: little\nencoding: raw\n\n" + bytes);
  };
  const std::string note =
      "its values from 1000000000 to 1000000000.07 are stored exactly, but pictures compute with 32-bit floats, which "
      "step by 64 there and make 1 value of them; subtract 1e+09 from the source's values";
  put(1e9, 0.01);
  expectNotes("a.nrrd", {note});
  EXPECT_NE(done({"render", in("o.kiln"), "-o", in("p.png"), "--size", "8x8"}).err.find(note), std::string::npos);
  put(0, 0.01);
  expectNotes("a.nrrd", {});
  put(1e9, 1e6);
  expectNotes("a.nrrd", {});
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
  refused({"convert", "phantom:head:16x16x16", in("h.kiln")}, 1, "has the name of a lock file, but is none; move it");
  EXPECT_EQ(readTextFile(in("h.kiln.lock")), "precious");
}

// A link to itself cannot be read.
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

// OpenVDB would print its own warning.
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

// Known: with the memory that a dry run names, no chunk is decoded twice.
TEST_F(Messages, DryRun_namesTheMemoryThatDecodesOnce) {
  writeZarr(in("d.zarr"), randomVolume({140, 120, 100}, VoxelType::u8, 41),
            {.axes = {{'z', 16}, {'y', 16}, {'x', 16}}});
  const auto run = [&](const std::string& memory, const std::string& last) {
    return done({"convert", in("d.zarr"), last, "--brick-size", "32", "--threads", "1", "--memory", memory}).out;
  };
  const std::string foretold = run("2500K", "--dry-run");
  const std::string words = "decoding     each block of 16 x 16 x 16 up to ", remedy = " times; once with --memory ";
  ASSERT_NE(foretold.find(words), std::string::npos) << foretold;
  ASSERT_NE(foretold.find(remedy), std::string::npos) << foretold;
  const std::size_t at = foretold.find(remedy) + remedy.size();
  const std::string enough = foretold.substr(at, foretold.find('\n', at) - at);
  EXPECT_NE(run(enough, "--dry-run").find("each block of 16 x 16 x 16 once\n"), std::string::npos);
  EXPECT_NE(run(enough, in("d.kiln")).find(", each block decoded once\n"), std::string::npos);
}

TEST_F(Messages, FaultsOfZarr_NameTheChunkOrTheHeader) {
  const ForeignVolume volume = randomVolume({5, 4, 3}, VoxelType::u16, 1);
  const auto convert = [&](const std::string& name) {
    return std::vector<std::string>{"convert", in(name), in("p.kiln"), "--spacing", "1,1,1"};
  };
  writeZarr(in("a.zarr"), volume, {.codec = ZarrCodec::kGzip});
  writeText(in("a.zarr/0.0.1"), "no gzip");
  refused(convert("a.zarr"), 1, in("a.zarr/0.0.1") + ": the gzip data are damaged");
  writeText(in("a.zarr/.zarray"), "{");
  refused(convert("a.zarr"), 1, in("a.zarr/.zarray") + ": byte 2: is no JSON");
  writeZarr(in("b.zarr/left"), volume);
  writeZarr(in("b.zarr/right"), volume);
  refused(convert("b.zarr"), 2, "holds 2 images or arrays: 'left' (3, 4, 5) uint16; 'right' (3, 4, 5) uint16; name");
  refused({"convert", in("b.zarr/left"), in("p.kiln"), "--dims", "5,4,3"}, 2, "--dims applies to headerless raw data");
}

}  // namespace
}  // namespace kiln::test
