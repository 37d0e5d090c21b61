// Names of the stores that are made of volume files. Known because a link and another spelling name one file.
#include "convert/foreign_cache.h"

#include <gtest/gtest.h>

#include "support/files/foreign_files.h"

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

}  // namespace
}  // namespace kiln::test
