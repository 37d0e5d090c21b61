// Names of the stores that are made of volume files. Known because a link and another spelling name one file.
#include "convert/foreign_cache.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "ingest/open_source.h"
#include "store/manifest/read_manifest.h"
#include "support/files/foreign_files.h"
#include "support/files/nifti_files.h"
#include "support/system/expect_error.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

TEST(StoreOfAFile, InANamedFolder_IsOneForAPartOfAFileByAllItsNames) {
  const ForeignFiles files;
  const fs::path& folder = files.directory();
  const std::string file = files.write("scan.h5", "content").string(), link = (folder / "link.h5").string();
  fs::create_symlink(file, link);
  const auto store_of = [&](const std::string& name) { return storePathOf({name, {}, "stores"}); };
  const fs::path store = store_of(file + ":/entry/data");
  EXPECT_TRUE(store.filename().string().starts_with("scan.h5.entry.data-")) << store;
  EXPECT_EQ(store.parent_path(), "stores");
  EXPECT_EQ(store_of(link + ":/entry/data"), store);
  EXPECT_EQ(store_of((folder / "." / "scan.h5").string() + ":/entry/data"), store);
  EXPECT_NE(store_of(file + ":/entry/other"), store);
  EXPECT_NE(store_of(file), store);
}

// A drawing of a file as labels changes no later drawing of its values.
TEST(StoreOfAFile, AsLabels_IsASecondStore) {
  const ForeignFiles files;
  const fs::path file = files.directory() / "f.nii";
  writeBytes(file, niftiFile({}, Bytes(60, 7)));
  Progress silent;
  const auto stored = [&](bool labels) {
    ConvertOptions options;
    options.command = "kiln render f.nii";
    options.labels = labels;
    return storeFor({file, {}, {}}, options, silent);
  };
  const fs::path values = stored(false), labels = stored(true);
  EXPECT_EQ(values, file.string() + ".kiln");
  EXPECT_EQ(labels, file.string() + ".labels.kiln");
  EXPECT_EQ(readManifest(values).volume_class, VolumeClass::kUnknown);
  EXPECT_EQ(readManifest(labels).volume_class, VolumeClass::kLabels);
  EXPECT_EQ(madeStoreFor({file, {}, {}}, UINT64_MAX, true), labels);
  // A store of values by the name of the labels' store, as a rename makes it, is made anew.
  fs::remove_all(labels);
  fs::rename(values, labels);
  expectError([&] { madeStoreFor({file, {}, {}}, UINT64_MAX, true); }, ErrorCode::kUsage, "--labels NAME.kiln");
  EXPECT_FALSE(madeStoreOf({file, {}, {}}, openSource(file)->info(), UINT64_MAX));
  EXPECT_EQ(stored(true), labels);
  EXPECT_EQ(readManifest(labels).volume_class, VolumeClass::kLabels);
}

}  // namespace
}  // namespace kiln::test
