// A store exported and read back by Kiln's own readers. Known because the test made the store's voxels and geometry,
// and because the readers are tested with files that share no code with the writers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "base/error.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "convert/convert.h"
#include "export/export_store.h"
#include "export/source/exported_volume.h"
#include "export/source/store_boxes.h"
#include "ingest/open_source.h"
#include "store/brick_index.h"
#include "store/manifest/read_manifest.h"
#include "support/files/foreign_files.h"
#include "support/system/faulty_file_system.h"
#include "support/system/impatient_progress.h"
#include "support/system/snapshot_disk.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kSmallBrick = 16;
constexpr Extent3 kSeveralBricks = {19, 17, 18};

/// A format by an example of a name, and what it keeps of a volume's place.
struct ExportCase {
  const char* name = "";
  bool compress = false;
  enum class Keeps { kAffine, kFloatAffine, kAnatomy, kSpacing } keeps = Keeps::kAffine;
};
using Keeps = ExportCase::Keeps;

const ExportCase kExportCases[] = {
    {"v.nrrd"},
    {"v.nrrd", true},
    {"v.nii", false, Keeps::kFloatAffine},
    {"v.nii.gz", false, Keeps::kFloatAffine},
    {"v.mha"},
    {"v.mhd"},
    {"v.raw", false, Keeps::kSpacing},
    {"v.tif", false, Keeps::kSpacing},
    {"v_###.tif", false, Keeps::kSpacing},
    {"v.zarr", false, Keeps::kAnatomy},
};

/// A disk that does not wait for its bytes; each wait takes longer than these exports.
class HastyDisk : public FileSystem {
 public:
  void syncFile(const fs::path&) override {}
  void syncAll(const fs::path&) override {}
};

class ExportFormats : public ::testing::Test {
 protected:
  // Calls `body` for each format, with an empty folder.
  void forEachFormat(const std::function<void()>& body) {
    for (const ExportCase& each : kExportCases) {
      SCOPED_TRACE(fmt::format("{}{}", each.name, each.compress ? ", compressed" : ""));
      format_ = each;
      directory_ = freshDirectory("out");
      body();
    }
  }

  fs::path out() const { return directory_ / format_.name; }
  ExportRequest request() const {
    ExportRequest out_request;
    out_request.out = out();
    out_request.compress = format_.compress;
    return out_request;
  }
  ExportRequest onDisk(FileSystem& disk) const {
    ExportRequest out_request = request();
    out_request.disk = &disk;
    return out_request;
  }
  ExportReport exported(const fs::path& store, ExportRequest request) {
    request.disk = &disk_;
    return exportStore(StoreReader(store), request, silent_);
  }
  std::unique_ptr<VolumeSource> reopened(const ExportedVolume& volume) const {
    SourceOptions options;
    if (fs::path(format_.name).extension() == ".raw") {
      options.dims = volume.geometry.dims;
      options.type = volume.type;
      options.spacing = volume.geometry.spacing();
    }
    return openSource(inSlices() ? directory_ : out(), options);
  }
  bool inSlices() const { return out().filename().string().find('#') != std::string::npos; }
  /// The file without which the output cannot be opened.
  fs::path lastFile() const {
    return inSlices() ? directory_ / "v_000.tif" : out().extension() == ".zarr" ? out() / "zarr.json" : out();
  }
  /// True if the format has words for the directions of the axes.
  bool keepsDirections(const VolumeGeometry& geometry) const {
    if (format_.keeps == Keeps::kSpacing) return false;
    const bool mirrored = geometry.world_from_index[0].x < 0, oblique = geometry.world_from_index[0].y != 0;
    return format_.keeps != Keeps::kAnatomy || !(oblique || (mirrored && geometry.frame == PatientFrame::kUnknown));
  }

  ExportCase format_;
  fs::path directory_;
  HastyDisk disk_;
  Progress silent_;
};

DenseVolume noiseOf(VoxelType type, const VolumeGeometry& geometry) {
  DenseVolume out = noise({geometry.dims, type}, 7, usualRange(type));
  out.geometry = geometry;
  return out;
}

VolumeGeometry placedAt(const glm::dmat4& affine, PatientFrame frame, const std::string& unit,
                        const Extent3& dims = kSeveralBricks) {
  return {dims, affine, frame, unit};
}

glm::dmat4 exactAffine() { return spacingAffine({0.5, 0.75, 2}, {-12.5, 30, 7.25}); }

DenseVolume volumeOf(VoxelType type) { return noiseOf(type, placedAt(exactAffine(), PatientFrame::kUnknown, "")); }

// Returns the store of a volume, made once for the tests of all formats.
const fs::path& storeOf(const std::string& name, const DenseVolume& volume) {
  static std::map<std::string, fs::path> stores;
  fs::path& out = stores[name];
  if (out.empty()) out = makeStore(volume, "store_" + name, kSmallBrick);
  return out;
}
const fs::path& storeOf(VoxelType type) { return storeOf(std::string(nameOf(type)), volumeOf(type)); }

// The affine of `found` in the directions of `frame`.
glm::dmat4 turnedTo(PatientFrame frame, const VolumeGeometry& found) { return affineIn(frame, found); }

void expectNear(const glm::dmat4& found, const glm::dmat4& expected, double relative) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(found[column][row], expected[column][row], relative * std::abs(expected[column][row]))
          << column << "," << row;
}

TEST_F(ExportFormats, EveryTypeComesBack) {
  forEachFormat([&] {
    for (const VoxelType type : kAllTypes) {
      const DenseVolume volume = volumeOf(type);
      ExportRequest overwriting = request();
      overwriting.overwrite = true;
      exported(storeOf(type), overwriting);
      const auto source = reopened(exportedVolume(StoreReader(storeOf(type)), 0, {}));
      ASSERT_EQ(source->info().type, type);
      ASSERT_EQ(source->info().geometry.dims, volume.geometry.dims);
      EXPECT_TRUE(readWhole(*source) == volume.voxels) << nameOf(type);
    }
  });
}

// The numbers of the first affine survive as floats; the others need doubles.
TEST_F(ExportFormats, ThePlaceInTheWorldComesBack) {
  forEachFormat([&] {
    const std::pair<glm::dmat4, double> affines[] = {
        {exactAffine(), 0},
        {mirroredAffine(exactAffine(), 0, kFewVoxels), 0},
        {anisotropicAffine(), format_.keeps == Keeps::kFloatAffine ? 1e-7 : 0},
        {obliqueAffine(), format_.keeps == Keeps::kFloatAffine ? 1e-7 : 4e-16}};
    for (const auto& [affine, error] : affines) {
      for (const PatientFrame frame : {PatientFrame::kUnknown, PatientFrame::kRas, PatientFrame::kLps}) {
        const DenseVolume volume = noiseOf(VoxelType::u8, placedAt(affine, frame, "mm", kFewVoxels));
        ExportRequest overwriting = request();
        overwriting.overwrite = true;
        exported(storeOf(fmt::format("affine_{}_{}", affine[0][0], static_cast<int>(frame)), volume), overwriting);
        const VolumeGeometry found =
            reopened({0, boxOf(kFewVoxels), volume.geometry, VoxelType::u8, VolumeClass::kUnknown, 0})->info().geometry;
        if (format_.keeps != Keeps::kSpacing || fs::path(format_.name).extension() == ".tif") {
          EXPECT_EQ(found.unit, "mm");
        }
        if (!keepsDirections(volume.geometry)) {
          EXPECT_EQ(found.spacing(), volume.geometry.spacing());
          continue;
        }
        EXPECT_EQ(found.frame == PatientFrame::kUnknown,
                  frame == PatientFrame::kUnknown && format_.keeps != Keeps::kFloatAffine);
        expectNear(frame == PatientFrame::kUnknown ? found.world_from_index : turnedTo(frame, found), affine, error);
      }
    }
  });
}

TEST_F(ExportFormats, ARegionOfALevelComesBack) {
  forEachFormat([&] {
    const DenseVolume volume = noiseOf(VoxelType::u16, placedAt(exactAffine(), PatientFrame::kRas, "mm", {30, 20, 24}));
    const fs::path& path = storeOf("levels", volume);
    const StoreReader store(path);
    // Only x has voxels so short that level 1 halves their number.
    for (const int level : {0, 1}) {
      ExportRequest part = request();
      part.level = level;
      part.region = VoxelBox{{-5, 3, 7}, {25, 15, 90}};
      part.overwrite = true;
      exported(path, part);
      const VoxelBox expected = level == 0 ? VoxelBox{{0, 3, 7}, {25, 15, 24}} : VoxelBox{{0, 3, 7}, {13, 15, 24}};
      const ExportedVolume wanted = exportedVolume(store, level, part.region);
      ASSERT_EQ(wanted.box, expected);
      std::vector<std::byte> voxels(wanted.bytes());
      readBox(store, level, expected, silent_, voxels);
      const auto source = reopened(wanted);
      ASSERT_EQ(source->info().geometry.dims, expected.extent());
      EXPECT_TRUE(readWhole(*source) == voxels);
      if (format_.keeps == Keeps::kSpacing) continue;
      const glm::dvec3 lo(expected.lo.x, expected.lo.y, expected.lo.z);
      EXPECT_EQ(turnedTo(PatientFrame::kRas, source->info().geometry)[3],
                glm::dvec4(store.level(level).geometry.worldOf(lo), 1));
    }
  });
}

// Each budget from the least on gives equal bytes.
TEST_F(ExportFormats, BytesDoNotDependOnMemoryOrThreads) {
  forEachFormat([&] {
    const fs::path& store = storeOf(VoxelType::f32);
    ExportRequest overwriting = request();
    exported(store, overwriting);
    const auto expected = filesOf(directory_);
    overwriting.overwrite = true;
    std::uint64_t refused = 0;
    for (std::uint64_t bytes = 64 << 10; bytes < (64 << 20); bytes *= 2) {
      overwriting.memory_bytes = bytes;
      const ThreadLimit threads(bytes % 3 + 1);
      try {
        exported(store, overwriting);
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kBudget) << error.what();
        ++refused;
      }
      ASSERT_TRUE(filesOf(directory_) == expected) << bytes;
    }
    EXPECT_GT(refused, 0u);
  });
}

// Whatever call fails, the folder holds the old files or the new files.
TEST_F(ExportFormats, AFailingDiskLeavesOldOrNewFiles) {
  forEachFormat([&] {
    const fs::path& store = storeOf(VoxelType::u8);
    FaultyFileSystem counting;
    ExportRequest thin = onDisk(counting);
    thin.region = VoxelBox{{0, 0, 0}, {19, 17, 4}};
    exportStore(StoreReader(store), thin, silent_);
    // Each third of the many equal calls of formats of several files.
    for (std::uint64_t n = 0; n<counting.calls(); n += counting.calls()> 20 ? 3 : 1) {
      fs::remove_all(directory_);
      fs::create_directory(directory_);
      FaultyFileSystem disk({n});
      try {
        thin.disk = &disk;
        exportStore(StoreReader(store), thin, silent_);
        ADD_FAILURE() << "call " << n << " did not fail";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kNoSpace) << error.what();
        EXPECT_EQ(std::string(error.what()).find(".kiln-0"), std::string::npos) << error.what();
      }
      const auto left = filesOf(directory_);
      EXPECT_FALSE(fs::exists(lastFile())) << "after call " << n;
      for (const auto& [name, bytes] : left) {
        EXPECT_TRUE(name.ends_with(".raw") || name.starts_with("v.zarr.partial/")) << name << " after call " << n;
      }
    }
  });
}

TEST_F(ExportFormats, AnInterruptLeavesNothing) {
  forEachFormat([&] {
    const fs::path& store = storeOf(VoxelType::u8);
    for (const int polls : {0, 1, 7}) {
      ImpatientProgress progress(polls);
      expectError([&] { exportStore(StoreReader(store), request(), progress); }, ErrorCode::kCancelled, "");
      EXPECT_TRUE(filesOf(directory_).empty());
    }
  });
}

TEST_F(ExportFormats, AFileThatIsThereIsKept) {
  forEachFormat([&] {
    const fs::path& store = storeOf(VoxelType::u8);
    fs::create_directories(lastFile().parent_path());
    writeText(lastFile(), "precious");
    expectError([&] { exported(store, request()); }, ErrorCode::kExists, "");
    EXPECT_EQ(readTextFile(lastFile()), "precious");
  });
}

class ExportStore : public ::testing::Test {
 protected:
  fs::path store(const VolumeGeometry& geometry) const {
    constexpr std::int64_t kLargeBrick = 256;
    return makeStore(noiseOf(VoxelType::u8, geometry), "store", kLargeBrick);
  }
  fs::path directory_ = freshDirectory("out");
  Progress silent_;
};

// NIfTI-1 has 16 bits for an extent. Only the last bricks hold two values.
TEST_F(ExportStore, LongVolumesAreNifti2) {
  DenseVolume volume = slab({{33000, 2, 3}, VoxelType::u8, spacingAffine({0.1, 0.2, 0.3})}, 0, 32900, 32990, 9);
  volume.geometry.frame = PatientFrame::kRas;
  volume.geometry.unit = "um";
  ExportRequest request;
  request.out = directory_ / "long.nii";
  exportStore(StoreReader(makeStore(volume, "long", 64)), request, silent_);
  const auto source = openSource(request.out);
  EXPECT_TRUE(source->info().format.starts_with("NIfTI-2"));
  EXPECT_EQ(source->info().geometry.dims, volume.geometry.dims);
  EXPECT_EQ(source->info().geometry.world_from_index, volume.geometry.world_from_index);
  EXPECT_EQ(source->info().geometry.unit, "um");
  EXPECT_TRUE(readWhole(*source) == volume.voxels);
}

// 0.25 nm are 0.00000025 mm.
TEST_F(ExportStore, UnitsThatAFormatLacksAreConverted) {
  const fs::path small = store(placedAt(spacingAffine({0.25, 0.5, 1}), PatientFrame::kUnknown, "nm"));
  for (const char* const name : {"v.mha", "v.nii"}) {
    ExportRequest request;
    request.out = directory_ / name;
    exportStore(StoreReader(small), request, silent_);
    const VolumeGeometry found = openSource(request.out)->info().geometry;
    EXPECT_EQ(found.unit, "mm");
    EXPECT_NEAR(found.spacing().x, 2.5e-7, 1e-14);
  }
}

// Known: stores keep a unit as their source spelled the unit.
TEST_F(ExportStore, UnitOfAnotherSpelling_isTheUnitOfTheFormat) {
  const fs::path micron = store(placedAt(spacingAffine({0.25, 0.5, 1}), PatientFrame::kUnknown, "micron"));
  for (const char* const name : {"v.mha", "v.nii", "v.nrrd", "v.tif", "v.zarr"}) {
    ExportRequest request;
    request.out = directory_ / name;
    exportStore(StoreReader(micron), request, silent_);
    const VolumeGeometry found = openSource(request.out)->info().geometry;
    EXPECT_EQ(found.unit, "um") << name;
    EXPECT_EQ(found.spacing(), glm::dvec3(0.25, 0.5, 1)) << name;
  }
}

std::vector<std::byte> voxelsIn(const fs::path& path) { return readWhole(*openSource(path)); }

// Two shards along x and one of the next level. After a fault at a call the export goes on behind its whole shards; a
// cut shard is made anew.
TEST_F(ExportStore, AnInterruptedZarrGoesOnBehindItsLastShard) {
  const VolumeGeometry geometry = placedAt(exactAffine(), PatientFrame::kRas, "mm", {400, 5, 3});
  const fs::path several = store(geometry);
  ExportRequest request;
  request.out = directory_ / "v.zarr";
  FaultyFileSystem counting;
  request.disk = &counting;
  exportStore(StoreReader(several), request, silent_);
  const auto expected = filesOf(directory_);
  EXPECT_TRUE(voxelsIn(request.out) == noiseOf(VoxelType::u8, geometry).voxels);
  int kept = 0;
  for (std::uint64_t n = 0; n < counting.calls(); n += 2) {
    fs::remove_all(directory_);
    fs::create_directory(directory_);
    request.resume = false;
    FaultyFileSystem disk({.after_calls = n, .torn_write = true, .crash = true});
    request.disk = &disk;
    EXPECT_THROW(exportStore(StoreReader(several), request, silent_), Error);
    disk.leaveWreckage();
    FaultyFileSystem rest;
    request.resume = true;
    request.disk = &rest;
    exportStore(StoreReader(several), request, silent_);
    EXPECT_TRUE(filesOf(directory_) == expected) << "after call " << n;
    kept += rest.calls() + 9 < counting.calls() ? 1 : 0;
  }
  EXPECT_GT(kept, 0);
}

TEST_F(ExportStore, AFinishedZarrIsKeptByResumeOnlyIfItIsOfTheSameExport) {
  const fs::path small = store(placedAt(exactAffine(), PatientFrame::kRas, "mm", {9, 5, 3}));
  ExportRequest request;
  request.out = directory_ / "v.zarr";
  const ExportReport first = exportStore(StoreReader(small), request, silent_);
  const auto written = filesOf(directory_);
  request.resume = true;
  FaultyFileSystem disk;
  request.disk = &disk;
  const ExportReport again = exportStore(StoreReader(small), request, silent_);
  EXPECT_EQ(disk.calls(), 0u) << "nothing is written";
  EXPECT_EQ(again.contents, first.contents);
  EXPECT_EQ(again.bytes, first.bytes);
  EXPECT_TRUE(filesOf(directory_) == written);
  const fs::path in_metres = store(placedAt(exactAffine(), PatientFrame::kRas, "m", {9, 5, 3}));
  expectError([&] { exportStore(StoreReader(in_metres), request, silent_); }, ErrorCode::kExists, "--overwrite");
  request.region = VoxelBox{{0, 0, 0}, {8, 5, 3}};
  expectError([&] { exportStore(StoreReader(small), request, silent_); }, ErrorCode::kExists, "--overwrite");
}

// Window and colours are in the header alone: the voxels of both exports are equal.
TEST_F(ExportStore, FinishedZarrOfAnotherLook_isNotKeptByResume) {
  const fs::path small = store(placedAt(exactAffine(), PatientFrame::kRas, "mm", {9, 5, 3}));
  const auto declare = [&](double end) {
    Manifest manifest = readManifest(small);
    manifest.format = kFormatVersion;
    manifest.look.ramp = DeclaredLook::Ramp{0, end, {255, 128, 3}};
    writeText(small / "manifest.json", manifestText(manifest));
  };
  ExportRequest request;
  request.out = directory_ / "v.zarr";
  request.resume = true;
  declare(100);
  exportStore(StoreReader(small), request, silent_);
  exportStore(StoreReader(small), request, silent_);
  declare(200);
  expectError([&] { exportStore(StoreReader(small), request, silent_); }, ErrorCode::kExists, "--overwrite");
  request.overwrite = true;
  exportStore(StoreReader(small), request, silent_);
  EXPECT_EQ(openSource(request.out, {})->info().look.ramp->end, 200);
}

// The memory of an export beside the index follows from the index, which is not read.
TEST_F(ExportStore, BudgetBelowTheIndex_isNotNamedAsSufficient) {
  const fs::path small = store(placedAt(exactAffine(), PatientFrame::kRas, "mm", {9, 5, 3}));
  expectError([&] { StoreReader(small, 100); }, ErrorCode::kBudget, "and bricks take more; give more than --memory 1M");
}

// A kill before the mark of an export leaves an empty folder; other folders are kept.
TEST_F(ExportStore, AFolderInTheWayIsReplacedOnlyIfItIsEmpty) {
  const fs::path small = store(placedAt(exactAffine(), PatientFrame::kUnknown, ""));
  ExportRequest request;
  request.out = directory_ / "v.zarr";
  fs::create_directory(directory_ / "v.zarr.partial");
  exportStore(StoreReader(small), request, silent_);
  EXPECT_FALSE(fs::exists(directory_ / "v.zarr.partial"));
  fs::create_directory(directory_ / "v.zarr.partial");
  writeText(directory_ / "v.zarr.partial/precious", "precious");
  request.overwrite = true;
  EXPECT_THROW(exportStore(StoreReader(small), request, silent_), Error);
  EXPECT_TRUE(fs::exists(directory_ / "v.zarr.partial/precious"));
}

TEST_F(ExportStore, AnUnfinishedZarrIsNotMixedWithAnother) {
  const fs::path several = store(placedAt(exactAffine(), PatientFrame::kRas, "mm", {400, 5, 3}));
  ExportRequest request;
  request.out = directory_ / "v.zarr";
  FaultyFileSystem disk({.after_calls = 14});
  request.disk = &disk;
  EXPECT_THROW(exportStore(StoreReader(several), request, silent_), Error);
  request.disk = nullptr;
  const fs::path shard = directory_ / "v.zarr.partial/0/c/0/0/0";
  ASSERT_TRUE(fs::exists(shard));
  const auto expectRefusal = [&](ErrorCode code, const char* part) {
    expectError([&] { exportStore(StoreReader(several), request, silent_); }, code, part);
  };
  expectRefusal(ErrorCode::kExists, "--resume");
  request.resume = true;
  request.region = VoxelBox{{0, 0, 0}, {399, 5, 3}};
  expectRefusal(ErrorCode::kExists, "another store, level or region");
  request.region.reset();
  const std::string manifest = readTextFile(several / "manifest.json");
  Manifest another = readManifest(several);
  another.background += 1;
  writeText(several / "manifest.json", manifestText(another));
  expectRefusal(ErrorCode::kExists, "another store, level or region");
  writeText(several / "manifest.json", manifest);
  request.memory_bytes = 1 << 20;
  expectRefusal(ErrorCode::kBudget, "--memory");
  request.memory_bytes = UINT64_MAX;
  ASSERT_TRUE(fs::exists(shard)) << "kept for a run with more memory";
  fs::resize_file(shard, fs::file_size(shard) - 1);
  exportStore(StoreReader(several), request, silent_);
  EXPECT_TRUE(voxelsIn(request.out) == noiseOf(VoxelType::u8, StoreReader(several).manifest().geometry()).voxels);
}

// Four slices replace two, and the export is killed at each rename. Known: the next export, which may replace nothing,
// finds a whole stack of one of both.
TEST_F(ExportStore, KilledSlices_areAWholeStackToTheNextExport) {
  constexpr std::int64_t kOld = 2, kNew = 4;
  const StoreReader several(store(placedAt(exactAffine(), PatientFrame::kUnknown, "", {9, 5, kNew})));
  const auto slicesIn = [](const fs::path& folder, std::int64_t slices) {
    ExportRequest out;
    out.out = folder / "v_#.tif";
    out.region = VoxelBox{{0, 0, 0}, {slices + 1, 5, slices}};
    out.overwrite = slices == kNew;
    return out;
  };
  const auto stackOf = [&](std::int64_t slices) {
    const fs::path folder = directory_ / std::to_string(slices);
    fs::create_directory(folder);
    exportStore(several, slicesIn(folder, slices), silent_);
    return filesOf(folder);
  };
  const auto older = stackOf(kOld), newer = stackOf(kNew);
  const fs::path work = directory_ / std::to_string(kOld);
  SnapshotDisk disk(work, directory_ / "killed");
  ExportRequest replacing = slicesIn(work, kNew);
  replacing.disk = &disk;
  exportStore(several, replacing, silent_);
  ASSERT_TRUE(filesOf(work) == newer);
  int undone = 0;
  for (const fs::path& killed : disk.snapshots()) {
    expectError([&] { exportStore(several, slicesIn(killed, kOld), silent_); }, ErrorCode::kExists, "v_");
    const auto left = filesOf(killed);
    EXPECT_TRUE(left == older || left == newer) << killed;
    undone += left == older ? 1 : 0;
    exportStore(several, slicesIn(killed, kNew), silent_);
    EXPECT_TRUE(filesOf(killed) == newer) << killed;
  }
  // Killed before the renames of the mark, of the old slices and of the first new slice.
  EXPECT_EQ(undone, 2 + kOld);
  EXPECT_EQ(disk.snapshots().size(), 1 + kOld + kNew);
}

// Each level of the pyramid is a scale. Labels stay labels, and bricks of background take no space.
TEST_F(ExportStore, ZarrHoldsThePyramid) {
  DenseVolume volume = slab({{40, 36, 33}, VoxelType::u8, exactAffine()}, 0, 3, 9, 5);
  volume.geometry.frame = PatientFrame::kLps;
  const StoreReader labels(makeStore(volume, "labels", kSmallBrick, /*labels=*/true));
  ExportRequest request;
  request.out = directory_ / "v.ome.zarr/";
  exportStore(labels, request, silent_);
  ASSERT_GT(labels.index().levels(), 1);
  for (int level = 0; level < labels.index().levels(); ++level) {
    SourceOptions options;
    options.scale = level;
    const auto source = openSource(request.out, options);
    const VolumeGeometry& geometry = labels.level(level).geometry;
    std::vector<std::byte> voxels(static_cast<std::size_t>(geometry.dims.count()));
    readBox(labels, level, boxOf(geometry.dims), silent_, voxels);
    EXPECT_TRUE(readWhole(*source) == voxels);
    EXPECT_EQ(turnedTo(PatientFrame::kLps, source->info().geometry), geometry.world_from_index);
    EXPECT_EQ(source->info().volume_class, VolumeClass::kLabels);
  }
}

TEST_F(ExportStore, WrongRequestsAreRefused) {
  const fs::path small = store(placedAt(exactAffine(), PatientFrame::kUnknown, ""));
  const auto expectRefusal = [&](const char* name, const char* part,
                                 const std::function<void(ExportRequest&)>& change = {}) {
    ExportRequest request;
    request.out = directory_ / name;
    if (change) change(request);
    expectError([&] { exportStore(StoreReader(small), request, silent_); }, ErrorCode::kUsage, part);
  };
  expectRefusal("v.xyz", "write .nrrd, ");
  expectRefusal("v.nii", "--compress", [](ExportRequest& r) { r.compress = true; });
  expectRefusal("v.nii", "--resume", [](ExportRequest& r) { r.resume = true; });
  expectRefusal("v.nii", "--tiles", [](ExportRequest& r) { r.tiles = 2; });
  expectRefusal("v.nii", "--tolerance", [](ExportRequest& r) { r.values.tolerance = 2; });
  expectRefusal("v.nrrd", "--region", [](ExportRequest& r) { r.region = VoxelBox{{90, 0, 0}, {99, 9, 9}}; });
  expectRefusal("50%.mhd", ".mha");
  EXPECT_TRUE(filesOf(directory_).empty());
}

// A volume that others made, one of its files, and a link into the store: an export with --overwrite leaves each.
TEST_F(ExportStore, SourceOfTheStore_isNotReplaced) {
  const ForeignVolume volume = randomVolume({20, 18, 17}, VoxelType::u8, 71);
  writeText(directory_ / "v.raw", volume.stored(false));
  writeText(directory_ / "v.nhdr",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 18 17\nencoding: raw\ndata file: v.raw\n");
  const fs::path path = freshDirectory("of_source") / "v.kiln";
  ConvertOptions options;
  options.brick_size = kSmallBrick;
  convert(*openSource(directory_ / "v.nhdr"), path, options, silent_);
  fs::create_symlink(directory_ / "v.raw", directory_ / "link.raw");
  fs::create_symlink(path / "bricks/0/0_0_0.vdb", directory_ / "brick.raw");
  fs::create_directory(directory_ / "v.zarr");
  fs::rename(directory_ / "v.raw", directory_ / "v.zarr/v.raw");
  fs::create_symlink("v.zarr/v.raw", directory_ / "v.raw");
  const auto before = filesOf(directory_);
  const auto bricks = filesOf(path);
  const auto expectRefusal = [&](const char* name, const char* part) {
    ExportRequest request;
    request.out = directory_ / name;
    request.overwrite = true;
    expectError([&] { exportStore(StoreReader(path), request, silent_); }, ErrorCode::kUsage, part);
  };
  for (const char* name : {"v.raw", "v.mhd", "link.raw", "link.mhd"})
    expectRefusal(name, "from which the store was made");
  expectRefusal("v.zarr", "holds ");
  for (const char* name : {"brick.raw", "brick.mhd"}) expectRefusal(name, "would be in the store");
  EXPECT_TRUE(filesOf(directory_) == before);
  EXPECT_TRUE(filesOf(path) == bricks);
}

// Labels, notes and links are nobody's to remove.
TEST_F(ExportStore, ZarrFolder_isReplacedOnlyIfAnExportCouldHaveMadeIt) {
  const fs::path small = store(placedAt(exactAffine(), PatientFrame::kUnknown, ""));
  ExportRequest request;
  request.out = directory_ / "v.zarr";
  exportStore(StoreReader(small), request, silent_);
  request.overwrite = true;
  const auto own = filesOf(directory_);
  for (const char* name : {"notes.txt", "labels/zarr.json", "0/c/0/0/x", "1/zarr.json", "0/0/zarr.json"}) {
    const fs::path other = request.out / name;
    fs::create_directories(other.parent_path());
    writeText(other, "precious");
    expectError([&] { exportStore(StoreReader(small), request, silent_); }, ErrorCode::kExists, name);
    EXPECT_EQ(readTextFile(other), "precious");
    fs::remove(other);
  }
  fs::create_directory(directory_ / "others");
  fs::create_directory_symlink("../../others", request.out / "0/link");
  expectError([&] { exportStore(StoreReader(small), request, silent_); }, ErrorCode::kExists, "0/link");
  fs::remove(request.out / "0/link");
  exportStore(StoreReader(small), request, silent_);
  EXPECT_TRUE(filesOf(directory_) == own);
  for (const char* header : {"{}", "not JSON", R"({"attributes": {"ome": {"multiscales": [{"datasets": 3}, 4]}}})"}) {
    writeText(request.out / "zarr.json", header);
    expectError([&] { exportStore(StoreReader(small), request, silent_); }, ErrorCode::kExists, "is no OME-Zarr image");
  }
}

TEST_F(ExportStore, ZarrNameOutsideUtf8_isEscapedInTheHeader) {
  const VolumeGeometry geometry = placedAt(exactAffine(), PatientFrame::kUnknown, "");
  ExportRequest request;
  request.out = directory_ / "v\xff.zarr";
  exportStore(StoreReader(store(geometry)), request, silent_);
  EXPECT_NE(readTextFile(request.out / "zarr.json").find(R"("v\\xff")"), std::string::npos);
  EXPECT_TRUE(voxelsIn(request.out) == noiseOf(VoxelType::u8, geometry).voxels);
}

struct Notes : Progress {
  void note(const std::string& sentence) override { all += sentence; }
  std::string all;
};

// The volume is from 0,0,0 to 19,17,18.
TEST_F(ExportStore, RegionBeyondTheVolume_isANoteWithTheBox) {
  const fs::path whole = store(placedAt(exactAffine(), PatientFrame::kUnknown, ""));
  ExportRequest request;
  request.out = directory_ / "v.nrrd";
  request.overwrite = true;
  const auto noteFor = [&](const VoxelBox& region) {
    Notes notes;
    request.region = region;
    exportStore(StoreReader(whole), request, notes);
    return notes.all;
  };
  EXPECT_EQ(noteFor({{-5, 3, 7}, {15, 90, 18}}),
            request.out.string() +
                ": --region reaches beyond the volume; the box that is written is 0,3,7,15,17,18 of level 0");
  EXPECT_EQ(noteFor({{0, 0, 0}, {19, 17, 18}}), "");
}

// Known because the manifest states the look, and OME-Zarr alone has words for it.
TEST_F(ExportStore, DeclaredLook_exported_comesBackFromZarrAndIsANoteElsewhere) {
  DeclaredLook window, colors;
  window.ramp = DeclaredLook::Ramp{-2.5, 1000, {255, 128, 3}};
  colors.labels = {{0, {1, 2, 3, 0}}, {7, {255, 0, 9}}};
  for (const DeclaredLook& look : {window, colors}) {
    const bool labels = !look.labels.empty();
    const fs::path path = makeStore(noise({{20, 9, 9}, VoxelType::u16}, 7, {0, 9}), "look", kSmallBrick, labels);
    Manifest manifest = readManifest(path);
    manifest.format = kFormatVersion;
    manifest.look = look;
    writeText(path / "manifest.json", manifestText(manifest));
    const StoreReader with_look(path);
    for (const char* name : {"v.zarr", "v.nrrd"}) {
      Notes notes;
      ExportRequest request;
      request.out = directory_ / name;
      request.overwrite = true;
      exportStore(with_look, request, notes);
      const bool keeps = request.out.extension() == ".zarr";
      EXPECT_EQ(openSource(request.out, {})->info().look, keeps ? look : DeclaredLook());
      EXPECT_EQ(notes.all.find("no place for the window or the colours") == std::string::npos, keeps) << notes.all;
    }
  }
}

// OpenVDB has neither; a volume without both loses nothing.
TEST_F(ExportStore, UnitFrameAndBoxThatGridsLack_areANote) {
  ExportRequest request;
  request.out = directory_ / "v.vdb";
  request.overwrite = true;
  const auto noteOf = [&](const fs::path& exported) {
    Notes notes;
    exportStore(StoreReader(exported), request, notes);
    return notes.all;
  };
  const auto noteFor = [&](PatientFrame frame, const char* unit) {
    return noteOf(store(placedAt(exactAffine(), frame, unit)));
  };
  EXPECT_EQ(noteFor(PatientFrame::kUnknown, ""),
            (directory_ / "v.vdb").string() +
                ": grids have no box; programs read the box of the active voxels, without the background around them");
  EXPECT_NE(noteFor(PatientFrame::kUnknown, "mm").find("v.vdb: grids have no unit"), std::string::npos);
  EXPECT_NE(noteFor(PatientFrame::kRas, "").find("no patient frame"), std::string::npos);
  const DenseVolume zeros = slab({{8, 8, 8}, VoxelType::u8, exactAffine()}, 0, 0, 8, 0);
  EXPECT_NE(noteOf(makeStore(zeros, "zeros", kSmallBrick, /*labels=*/false)).find("the grid is empty"),
            std::string::npos);
}

}  // namespace
}  // namespace kiln::test
