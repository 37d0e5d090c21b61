// Every reader and writer of the program while a system call fails. Allowed results: the files of a run without a
// fault, bit for bit; or one line of error, and no half-written file under a result's name. A call that a signal
// interrupts, or that moves fewer bytes, must change nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "base/file/file.h"
#include "call_faults.h"
#include "support/files/amira_files.h"
#include "support/files/dicom_files.h"
#include "support/files/foreign_files.h"
#include "support/files/hdf5_files.h"
#include "support/files/mrc_mgh_files.h"
#include "support/files/nifti_files.h"
#include "support/files/npy_files.h"
#include "support/files/packed_bytes.h"
#include "support/files/picture_files.h"
#include "support/files/tiff_files.h"
#include "support/files/vdb_files.h"
#include "support/files/vgi_files.h"
#include "support/files/vti_files.h"
#include "support/files/zarr_files.h"
#include "support/system/sanitized.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

using Folder = std::map<std::string, std::vector<std::byte>>;
using Arguments = std::vector<std::string>;

constexpr Extent3 kDims = {20, 18, 9};
constexpr int kBrick = 16;

/// A command on a folder filled by `prepare`. In the arguments @ stands for the folder.
struct Scenario {
  std::string name;
  Arguments arguments;
  std::function<void(const fs::path& folder)> prepare;
  bool writes = true;
  /// Results that contain times or random names, and therefore differ from run to run.
  std::set<std::string> timed;
  /// Exit code of a run without a fault. After 1 the folder is unchanged.
  int exit_code = 0;
};

void PrintTo(const Scenario& scenario, std::ostream* out) { *out << scenario.name; }

std::string replacedAll(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

Arguments in(const fs::path& folder, Arguments arguments) {
  for (std::string& argument : arguments) argument = replacedAll(argument, "@", folder.string());
  return arguments;
}

void run(const fs::path& folder, const Arguments& arguments) {
  const ToolUnderFault result = runUnderFault(in(folder, arguments), folder);
  if (result.exit_code != 0) throw std::runtime_error(result.err);
}

void put(const fs::path& path, std::string_view bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

ForeignVolume volume(VoxelType type = VoxelType::u16) { return randomVolume(kDims, type, 5); }

std::string nrrd(const std::string& more) {
  return "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 20 18 9\nendian: little\n" + more;
}
std::string metaImage(const std::string& more) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 20 18 9\nElementType = MET_USHORT\nElementByteOrderMSB = False\n" +
         more;
}
std::string nifti(bool pair) {
  NiftiHeader header;
  header.dim = {3, 20, 18, 9, 1, 1, 1, 1};
  header.datatype = 512, header.bitpix = 16;
  if (pair) header.magic = "ni1", header.vox_offset = 0;
  const std::string voxels = volume().stored(false);
  const Bytes bytes = pair ? niftiHeader(header) : niftiFile(header, Bytes(voxels.begin(), voxels.end()));
  return std::string(bytes.begin(), bytes.end());
}

std::string legacyVtk() {
  return "# vtk DataFile Version 3.0\na title\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 20 18 9\n"
         "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 3240\nSCALARS v unsigned_short\nLOOKUP_TABLE default\n" +
         volume().stored(true) + "\n";
}

void putTiffs(const fs::path& folder, const TiffLayout& layout) {
  fs::create_directories(folder);
  for (std::int64_t z = 0; z < kDims.z; ++z) writeTiff(folder / fmt::format("s{}.tif", z), volume(), z, z + 1, layout);
}

TiffLayout tiffLayout(int compression, int tile = 0) {
  TiffLayout out;
  out.compression = compression;
  out.tile = tile;
  out.strip_rows = tile > 0 ? 0 : 5;
  out.description = "ImageJ=1.53c\nimages=9\nslices=9\nunit=um\nspacing=2\n";
  out.x_resolution = out.y_resolution = 4, out.resolution_unit = 1;
  return out;
}

void putDicom(const fs::path& folder, std::optional<DicomCodec> codec = std::nullopt) {
  fs::create_directories(folder);
  const std::string voxels = volume(VoxelType::i16).stored(false);
  const std::size_t slice = 20 * 18 * 2;
  for (int z = 0; z < 5; ++z) {
    DicomSpec spec;
    spec.columns = 20, spec.rows = 18;
    spec.position = fmt::format("0\\0\\{}", z);
    spec.pixel_bytes = voxels.substr(static_cast<std::size_t>(z) * slice, slice);
    put(folder / fmt::format("{}.dcm", z), dicomFile(spec));
    if (codec) compressDicom(folder / fmt::format("{}.dcm", z), *codec);
  }
}

Scenario reader(const std::string& name, const std::string& input, std::function<void(const fs::path&)> prepare,
                const Arguments& more = {}) {
  Arguments arguments = {"convert", "@/" + input, "@/out.kiln", "--brick-size", "16", "--threads", "1"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return {name, arguments, std::move(prepare), true, {}};
}

std::vector<Scenario> readers() {
  const auto file = [](const std::string& name, const std::function<std::string()>& bytes, const Arguments& more = {}) {
    return reader(
        replacedAll(replacedAll(name, ".", "_"), "/", "_"), name,
        [name, bytes](const fs::path& f) { put(f / name, bytes()); }, more);
  };
  const auto stored = [] { return volume().stored(false); };
  std::vector<Scenario> out;
  out.push_back(file("a.raw", stored, {"--dims", "20,18,9", "--type", "u16"}));
  out.push_back(file("a.nrrd", [=] { return nrrd("encoding: raw\n\n") + stored(); }));
  out.push_back(file("gz.nrrd", [=] { return nrrd("encoding: gzip\n\n") + gzipped(stored()); }));
  out.push_back(reader("nhdr", "a.nhdr", [=](const fs::path& f) {
    put(f / "a.nhdr", nrrd("encoding: raw\ndata file: a.raw\n"));
    put(f / "a.raw", stored());
  }));
  out.push_back(reader("nhdr_gz", "a.nhdr", [=](const fs::path& f) {
    put(f / "a.nhdr", nrrd("encoding: gzip\ndata file: a.raw.gz\n"));
    put(f / "a.raw.gz", gzipped(stored()));
  }));
  out.push_back(file("a.mha", [=] { return metaImage("ElementDataFile = LOCAL\n") + stored(); }));
  out.push_back(
      file("z.mha", [=] { return metaImage("CompressedData = True\nElementDataFile = LOCAL\n") + zlibbed(stored()); }));
  out.push_back(reader("mhd", "a.mhd", [=](const fs::path& f) {
    put(f / "a.mhd", metaImage("ElementDataFile = a.raw\n"));
    put(f / "a.raw", stored());
  }));
  out.push_back(file("a.nii", [] { return nifti(false); }));
  out.push_back(file("a.nii.gz", [] { return gzipped(nifti(false)); }));
  out.push_back(reader("nifti_pair", "a.hdr", [=](const fs::path& f) {
    put(f / "a.hdr", nifti(true));
    put(f / "a.img", stored());
  }));
  for (const int compression : {1, 5, 8, 32773}) {
    out.push_back(reader(fmt::format("tiff_{}", compression), "a.tif", [=](const fs::path& f) {
      writeTiff(f / "a.tif", volume(), 0, kDims.z, tiffLayout(compression, compression == 8 ? 16 : 0));
    }));
  }
  TiffLayout big = tiffLayout(1);
  big.big_tiff = big.big_endian = true;
  out.push_back(reader("tiff_big", "a.tif", [=](const fs::path& f) { writeTiff(f / "a.tif", volume(), 0, 9, big); }));
  TiffLayout plain;
  out.push_back(reader("tiff_folder", "scan", [=](const fs::path& f) { putTiffs(f / "scan", plain); }));
  plain.compression = 5;
  out.push_back(reader("tiff_folder_lzw", "scan", [=](const fs::path& f) { putTiffs(f / "scan", plain); }));
  out.push_back(reader("dicom", "scan", [](const fs::path& f) { putDicom(f / "scan"); }));
  out.push_back(reader("dicom_rle", "scan", [](const fs::path& f) { putDicom(f / "scan", DicomCodec::kRle); }));
  out.push_back(reader("dicom_jpeg_ls", "scan", [](const fs::path& f) { putDicom(f / "scan", DicomCodec::kJpegLs); }));
  out.push_back(reader("vdb", "a.vdb", [](const fs::path& f) { writeVdb(f / "a.vdb", {VdbSpec{}}); }));
  out.push_back(reader("vdb_piped", "a.vdb", [](const fs::path& f) { writeVdb(f / "a.vdb", {VdbSpec{}}, false); }));
  ZarrLayout chunks{.codec = ZarrCodec::kBlosc};
  chunks.axes = {{'z', 9}, {'y', 18}, {'x', 10}};
  ZarrLayout shards{.version = ZarrVersion::kThree, .codec = ZarrCodec::kZstd};
  shards.axes = {{'z', 5}, {'y', 9}, {'x', 10}};
  shards.chunks_in_shard = 2;
  out.push_back(file("bz2.nrrd", [=] { return nrrd("encoding: bzip2\n\n") + bzipped(stored()); }));
  out.push_back(file("a.npy", [] { return npyFile(volume()); }));
  out.push_back(file("a.mrc", [] { return mrcFile(volume()); }));
  out.push_back(file("a.mgz", [] { return gzipped(mghFile(volume())); }));
  out.push_back(file("a.am", [] { return amiraFile(volume()); }));
  out.push_back(reader("vgi", "a.vgi", [=](const fs::path& f) {
    put(f / "a.vgi", vgiHeader(kDims, "unsigned integer", 16));
    put(f / "a.vol", stored());
  }));
  VtiLayout zlib;
  zlib.codec = 1;
  out.push_back(file("a.vti", [=] { return vtiFile(volume(), zlib); }));
  out.push_back(file("a.vtk", [] { return legacyVtk(); }));
  out.push_back(reader("png_folder", "scan", [](const fs::path& f) {
    for (std::int64_t z = 0; z < kDims.z; ++z) put(f / fmt::format("scan/s{}.png", z), pngSlice(volume(), z));
  }));
#ifdef KILN_TEST_OPENJPEG
  out.push_back(reader("jpeg2000_folder", "scan", [](const fs::path& f) {
    for (std::int64_t z = 0; z < kDims.z; ++z) put(f / fmt::format("scan/s{}.j2k", z), jpeg2000Slice(volume(), z));
  }));
#endif
#ifdef KILN_TEST_HDF5
  out.push_back(reader("hdf5", "a.h5", [](const fs::path& f) {
    fs::create_directories(f);
    Hdf5File(f / "a.h5").add("/v", volume(), {.chunk = {4, 9, 10}, .deflate = 1});
  }));
#endif
  out.push_back(reader("zarr", "a.zarr", [=](const fs::path& f) { writeZarr(f / "a.zarr", volume(), chunks); }));
  out.push_back(reader("zarr_shards", "a.zarr", [=](const fs::path& f) { writeZarr(f / "a.zarr", volume(), shards); }));
  return out;
}

void putStore(const fs::path& folder, const std::string& name = "s.kiln") {
  put(folder / "in.raw", volume().stored(false));
  run(folder, {"convert", "@/in.raw", "@/" + name, "--dims", "20,18,9", "--type", "u16", "--brick-size", "16"});
}

Arguments render(const std::string& out, const Arguments& more = {}) {
  Arguments all = {"render", "@/s.kiln", "-o", "@/" + out, "--size", "24x20", "--threads", "1", "--samples", "1"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

// Stops a command by a failed write, so that it can be resumed.
void interrupt(const fs::path& folder, const Arguments& arguments, double share) {
  const Folder before = filesOf(folder);
  const std::uint64_t calls = runUnderFault(in(folder, arguments), folder).callsOf(CallFailure::kNoSpace);
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && !before.contains(fs::relative(entry.path(), folder).string()))
      fs::remove(entry.path());
  }
  for (const auto& entry : std::vector<fs::directory_entry>(fs::directory_iterator(folder), {})) {
    if (entry.is_directory() && filesOf(entry.path()).empty()) fs::remove_all(entry.path());
  }
  const CallFault full{CallFailure::kNoSpace, static_cast<std::uint64_t>(share * static_cast<double>(calls))};
  if (runUnderFault(in(folder, arguments), folder, full).exit_code != 1) throw std::runtime_error("not interrupted");
}

std::vector<Scenario> writers() {
  std::vector<Scenario> out;
  const Arguments convert = {"convert", "@/in.raw",     "@/out.kiln", "--dims",    "20,18,9", "--type",
                             "u16",     "--brick-size", "16",         "--threads", "1"};
  const auto with = [](Arguments all, const Arguments& more) {
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const auto store = [](const fs::path& f) { putStore(f); };
  out.push_back({"resume",
                 with(convert, {"--resume"}),
                 [=](const fs::path& f) {
                   put(f / "in.raw", volume().stored(false));
                   interrupt(f, convert, 0.6);
                 },
                 true,
                 {}});
  out.push_back({"overwrite",
                 with(convert, {"--overwrite", "--half"}),
                 [](const fs::path& f) { putStore(f, "out.kiln"); },
                 true,
                 {}});
  out.push_back({"convert_exists", convert, [](const fs::path& f) { putStore(f, "out.kiln"); }, false, {}, 1});
  out.push_back({"export_exists",
                 {"export", "@/s.kiln", "@/out.vdb"},
                 [](const fs::path& f) {
                   putStore(f);
                   put(f / "out.vdb", "precious");
                 },
                 false,
                 {},
                 1});
  out.push_back({"export", {"export", "@/s.kiln", "@/out.vdb"}, store, true, {"out.vdb"}});
  out.push_back({"export_nrrd", {"export", "@/s.kiln", "@/out.nrrd", "--threads", "1"}, store, true, {}});
  out.push_back({"export_zarr", {"export", "@/s.kiln", "@/out.zarr", "--threads", "1"}, store, true, {}});
  out.push_back({"export_overwrite",
                 {"export", "@/s.kiln", "@/out.vdb", "--overwrite"},
                 [](const fs::path& f) {
                   putStore(f);
                   run(f, {"export", "@/s.kiln", "@/out.vdb", "--level", "1"});
                 },
                 true,
                 {"out.vdb"}});
  out.push_back({"png", render("p.png"), store, true, {}});
  out.push_back({"png_again",
                 render("p.png"),
                 [](const fs::path& f) {
                   putStore(f);
                   run(f, render("p.png", {"--azimuth", "20"}));
                 },
                 true,
                 {}});
  out.push_back({"tiff", render("p.tif"), store, true, {}});
  out.push_back({"jpeg", render("p.jpg", {"--background", "white"}), store, true, {}});
  out.push_back({"exr", render("p.exr", {"--aov", "depth,normal"}), store, true, {}});
  out.push_back({"companions",
                 render("p.png", {"--camera", "@/eye.gltf", "--mask", "@/m.kiln:1-3", "--tf", "@/f.json"}),
                 [](const fs::path& f) {
                   putStore(f);
                   std::string labels(20 * 18 * 9, '\2');
                   put(f / "m.raw", labels);
                   run(f, {"convert", "@/m.raw", "@/m.kiln", "--dims", "20,18,9", "--type", "u8", "--labels"});
                   put(f / "eye.gltf", R"({"asset": {"version": "2.0"},
                         "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 1}}],
                         "nodes": [{"camera": 0, "translation": [10, 9, 40]}]})");
                   put(f / "f.json",
                       R"({"kiln": 2,
                         "points": [{"value": 0, "color": "red", "opacity": 0},
                                    {"value": 65535, "color": "blue", "opacity": 1}],
                         "table": {"values": [0, 65535], "gradients": [0, 9000], "columns": 2,
                                   "opacity": [0, 0.5, 0.5, 1]}})");
                 },
                 true,
                 {}});
  out.push_back({"deep", render("p.exr", {"--deep"}), store, true, {}});
  out.push_back({"foreign",
                 {"render", "@/a.nrrd", "-o", "@/p.png", "--size", "24x20", "--threads", "1"},
                 [](const fs::path& f) { put(f / "a.nrrd", nrrd("encoding: raw\n\n") + volume().stored(false)); },
                 true,
                 {}});
  out.push_back({"statistics", render("p.png", {"--stats", "@/s.json"}), store, true, {"s.json"}});
  out.push_back({"trace", render("p.png", {"--trace", "@/t.json"}), store, true, {"t.json"}});
  const Arguments tiles = {"render",       "@/s.kiln",  "-o", "@/p.exr", "--size", "520x24",
                           "--checkpoint", "--threads", "1",  "--zoom",  "0.5"};
  out.push_back({"checkpoint", tiles, store, true, {}});
  out.push_back({"checkpoint_resume",
                 with(tiles, {"--resume"}),
                 [=](const fs::path& f) {
                   putStore(f);
                   interrupt(f, tiles, 0.7);
                 },
                 true,
                 {}});
  out.push_back({"sequence", render("p_##.png", {"--turntable", "3"}), store, true, {}});
  out.push_back({"sequence_resume",
                 render("p_##.png", {"--turntable", "3", "--resume"}),
                 [](const fs::path& f) {
                   putStore(f);
                   run(f, render("p_##.png", {"--turntable", "3", "--frames", "1-2"}));
                 },
                 true,
                 {}});
  // A substitute for ffmpeg that stores its input.
  out.push_back({"video",
                 render("v.mp4", {"--turntable", "3"}),
                 [](const fs::path& f) {
                   putStore(f);
                   put(f / "bin/ffmpeg", "#!/bin/sh\nfor last; do :; done\ncat > \"${last#file:}\"\n");
                   fs::permissions(f / "bin/ffmpeg", fs::perms::owner_all);
                 },
                 true,
                 {}});
  out.push_back({"slice", {"slice", "@/s.kiln", "-o", "@/s.png"}, store, true, {}});
  out.push_back({"slice_plane",
                 {"slice", "@/s.kiln", "-o", "@/s.jpg", "--plane", "1,2,1,-30", "--thickness", "3", "--pixel", "0.5"},
                 store,
                 true,
                 {}});
  out.push_back({"split", {"split", "@/s.kiln", "-o", "@/part_#.kiln", "--parts", "2"}, store, true, {}});
  out.push_back({"composite",
                 {"composite", "@/1.exr", "@/2.exr", "-o", "@/p.exr"},
                 [](const fs::path& f) {
                   putStore(f);
                   for (const std::string part : {"1", "2"}) run(f, render(part + ".exr", {"--part", part + "/2"}));
                 },
                 true,
                 {}});
  out.push_back({"tf", {"tf", "ct-bone", "-o", "@/tf.png"}, [](const fs::path&) {}, true, {}});
  const auto pictures = [](const fs::path& f) {
    putStore(f);
    run(f, render("a.exr"));
    run(f, render("b.png", {"--azimuth", "20"}));
  };
  out.push_back({"compare", {"compare", "@/a.exr", "@/b.png", "-o", "@/d.png"}, pictures, true, {}});
  out.push_back({"verify", {"verify", "@/s.kiln", "--threads", "1"}, store, false, {}});
  out.push_back({"info", {"info", "@/s.kiln"}, store, false, {}});
  out.push_back({"info_picture", {"info", "@/a.exr"}, pictures, false, {}});
  return out;
}

const char* nameOf(CallFailure failure) {
  constexpr const char* kNames[] = {"none", "EIO", "EINTR", "short count", "end of file", "ENOSPC"};
  return kNames[static_cast<int>(failure)];
}

// The lines of `text`.
std::vector<std::string> errorLines(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) out.push_back(line);
  }
  return out;
}

// A sequence prints a line for each failed frame and continues with the next frame.
std::size_t failedFrames(const std::vector<std::string>& lines) {
  return static_cast<std::size_t>(std::count_if(
      lines.begin(), lines.end(), [](const std::string& line) { return line.starts_with("kiln: frame "); }));
}

bool endsAs(const std::string& name, std::initializer_list<const char*> endings) {
  return std::any_of(endings.begin(), endings.end(), [&](const char* e) { return name.ends_with(e); });
}

// Unfinished work that a later command resumes or replaces, and that no command reads as a result: a store without a
// manifest, and tiles of a picture.
bool isUnfinished(const Folder& now, const std::string& name) {
  if (name.find(".partial/") != std::string::npos || name.find(".frames/") != std::string::npos ||
      endsAs(name, {".tiles", ".lock"}))
    return true;
  const std::size_t end = name.find(".kiln/");
  return end != std::string::npos &&
         (!now.contains(name.substr(0, end) + ".kiln/manifest.json") || name.ends_with("/journal.bin"));
}

// Every write of an OpenVDB file puts a random UUID into the header.
std::vector<std::byte> withoutUuid(std::vector<std::byte> vdb) {
  constexpr std::size_t kPlace = 21, kBytes = 36;
  if (vdb.size() > kPlace + kBytes) std::fill_n(vdb.begin() + kPlace, kBytes, std::byte{0});
  return vdb;
}

class CallFaults : public ::testing::TestWithParam<Scenario> {
 protected:
  void SetUp() override {
    folder_ = freshDirectory("call_faults_" + GetParam().name) / "work";
    fs::create_directories(folder_);
    GetParam().prepare(folder_);
    before_ = filesOf(folder_);
    faultless_ = runUnderFault(in(folder_, GetParam().arguments), folder_);
    ASSERT_EQ(faultless_.exit_code, GetParam().exit_code) << faultless_.err;
    whole_ = filesOf(folder_);
    ASSERT_EQ(whole_ != before_, GetParam().writes);
    restore(whole_);
  }

  // Restores the folder's initial contents.
  void restore(const Folder& now) const {
    for (const auto& [name, bytes] : now) {
      if (!before_.contains(name)) fs::remove(folder_ / name);
    }
    for (const auto& entry : std::vector<fs::directory_entry>(fs::directory_iterator(folder_), {})) {
      if (entry.is_directory() && filesOf(entry.path()).empty()) fs::remove_all(entry.path());
    }
    for (const auto& [name, bytes] : before_) {
      const auto found = now.find(name);
      if (found != now.end() && found->second == bytes) continue;
      fs::create_directories((folder_ / name).parent_path());
      FileSystem::real().writeFile(folder_ / name, bytes, WritePolicy::kUnsynced);
    }
  }

  bool isWhole(const std::string& name, const std::vector<std::byte>& bytes) const {
    const auto found = whole_.find(name);
    if (found == whole_.end()) return false;
    if (!GetParam().timed.contains(name)) return found->second == bytes;
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (name.ends_with(".vdb")) return withoutUuid(bytes) == withoutUuid(found->second);
    return text.starts_with("{") && text.ends_with("}\n");
  }

  // A failed removal may leave only temporary files.
  static bool isRemoving(const std::string& call) {
    return call.starts_with("unlink") || call.starts_with("remove") || call.starts_with("openat");
  }

  bool isBefore(const std::string& name, const std::vector<std::byte>& bytes) const {
    const auto found = before_.find(name);
    return found != before_.end() && found->second == bytes;
  }

  void expectWhole(const Folder& now, const std::string& failed_call) const {
    for (const auto& [name, bytes] : whole_) {
      const auto found = now.find(name);
      if (found == now.end())
        ADD_FAILURE() << name << " is missing after exit code 0";
      else
        EXPECT_TRUE(isWhole(name, found->second)) << name << " is another after exit code 0";
    }
    for (const auto& [name, bytes] : now)
      EXPECT_TRUE(whole_.contains(name) || isRemoving(failed_call)) << name << " was left behind";
  }

  void expectNothingHalf(const Folder& now, const std::string& failed_call) const {
    for (const auto& [name, bytes] : now) {
      if (isUnfinished(now, name) || isWhole(name, bytes) || isBefore(name, bytes)) continue;
      if (isRemoving(failed_call) && name.ends_with(".tmp")) continue;
      ADD_FAILURE() << name << " is neither the old file nor the new one";
    }
    for (const auto& [name, bytes] : before_) {
      EXPECT_TRUE(isUnfinished(before_, name) || now.contains(name)) << name << " was lost";
    }
    // A folder with a manifest is a store.
    for (const auto& [name, bytes] : now) {
      if (!name.ends_with("manifest.json") || isUnfinished(now, name) || isBefore(name, bytes)) continue;
      const std::string store = name.substr(0, name.size() - std::string("manifest.json").size());
      for (const auto& [other, of_whole] : whole_) {
        EXPECT_TRUE(!other.starts_with(store) || now.contains(other)) << store << " lacks " << other;
      }
    }
  }

  // Returns whether a call failed.
  bool meet(const CallFault& fault) {
    const ToolUnderFault result = runUnderFault(in(folder_, GetParam().arguments), folder_, fault);
    const Folder now = filesOf(folder_);
    SCOPED_TRACE(fmt::format("{} at call {}, {}: exit code {}\n{}", nameOf(fault.failure), fault.after_calls,
                             result.failed_call, result.exit_code, result.err));
    // Excluded: a read may end at the end of a file; an interrupted close is complete; fopen cannot be repeated.
    const bool harmless = (fault.failure == CallFailure::kInterrupted || fault.failure == CallFailure::kShort) &&
                          !result.failed_call.starts_with("close") && !result.failed_call.starts_with("fopen") &&
                          !result.failed_call.starts_with("fclose");
    if (GetParam().exit_code != 0) {
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_TRUE(now == before_) << "a refused command changed the folder";
    } else if (result.exit_code == 0) {
      expectWhole(now, result.failed_call);
      EXPECT_TRUE(GetParam().writes || result.out == faultless_.out) << result.out;
    } else {
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_FALSE(harmless || result.failed_call.empty());
      const std::vector<std::string> lines = errorLines(result.err);
      // The last line is the error; a note on the kept bricks or frames may precede.
      EXPECT_TRUE(!lines.empty() && lines.size() <= errorLines(faultless_.err).size() + 2 + failedFrames(lines) &&
                  lines.back().starts_with("kiln: "));
      EXPECT_EQ(lines.empty() ? 0u : lines.back().find("defect"), lines.empty() ? 0u : std::string::npos);
      expectNothingHalf(now, result.failed_call);
    }
    restore(now);
    return !result.failed_call.empty();
  }

  // Fails `runs` calls of each kind, evenly spread, or every call if there are fewer.
  void meetSome(std::uint64_t runs) {
    int failed_calls = 0;
    for (const CallFailure failure :
         {CallFailure::kIo, CallFailure::kInterrupted, CallFailure::kShort, CallFailure::kEnd, CallFailure::kNoSpace}) {
      if (failure == CallFailure::kNoSpace && !GetParam().writes) continue;
      const std::uint64_t calls = faultless_.callsOf(failure);
      const std::uint64_t step = std::max<std::uint64_t>(calls / runs, 1);
      // The first failing call differs between scenarios.
      const std::uint64_t first = std::hash<std::string>()(GetParam().name + nameOf(failure)) % step;
      for (std::uint64_t n = first; n < calls; n += step) {
        failed_calls += meet({failure, n}) ? 1 : 0;
        if (HasFatalFailure()) return;
      }
    }
    RecordProperty("failed_calls", failed_calls);
  }

  fs::path folder_;
  Folder before_, whole_;
  ToolUnderFault faultless_;
};

// Fails a few calls of each kind; the nightly test fails all.
TEST_P(CallFaults, SomeCalls_GiveTheResultOrOneError) { meetSome(casesOf(4, 2)); }
TEST_P(CallFaults, NightlyEveryCall_GivesTheResultOrOneError) { meetSome(UINT64_MAX); }

std::vector<Scenario> all() {
  std::vector<Scenario> out = readers();
  for (Scenario& scenario : writers()) out.push_back(std::move(scenario));
  return out;
}

INSTANTIATE_TEST_SUITE_P(Program, CallFaults, ::testing::ValuesIn(all()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace kiln::test
