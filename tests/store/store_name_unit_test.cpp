// Names of volumes in figures: a store of a volume file has the name of the file.
#include <gtest/gtest.h>

#include "store/manifest/store_name.h"

namespace kiln {
namespace {

TEST(StoreName, IsTheVolumesName) {
  EXPECT_EQ(volumeNameOf("a/head.kiln"), "head");
  EXPECT_EQ(volumeNameOf("a/head.kiln/"), "head");
  EXPECT_EQ(volumeNameOf("s/" + hashedStoreName("ch2.nii.gz", "e4b9e2e77dea")), "ch2.nii.gz");
  EXPECT_EQ(volumeNameOf("scan-2024.kiln"), "scan-2024");
  EXPECT_EQ(volumeNameOf("-e4b9e2e77dea.kiln"), "-e4b9e2e77dea");
}

}  // namespace
}  // namespace kiln
