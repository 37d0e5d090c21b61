// Known answers: each point's value, opacity and colour; each way to get a text wrong.
#include "job/json/points_text.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "base/error.h"
#include "image/named_color.h"
#include "job/render_job.h"

namespace kiln {
namespace {

TEST(PointsText, ValuesOpacitiesAndColours_areThoseOfTheText) {
  const TransferFunction f = functionOfPoints("-300.5:0:red,500:0.5,500:0.25:#f80,1e3:1:white");
  EXPECT_EQ(f.unit, 0);
  ASSERT_EQ(f.points.size(), 4u);
  EXPECT_EQ(f.points[0].value, -300.5);
  EXPECT_EQ(f.points[1].opacity, 0.5);
  EXPECT_EQ(f.points[2].opacity, 0.25);
  EXPECT_EQ(f.points[3].value, 1000);
  EXPECT_EQ(f.points[1].color, *colorNamed("red"));  // of the point before
  EXPECT_EQ(f.points[2].color, *colorNamed("#f80"));
  EXPECT_EQ(f.at(500).opacity, 0.25);  // a step
}

TEST(PointsText, FirstPointsWithoutColour_haveTheNextColourOrWhite) {
  const TransferFunction f = functionOfPoints("0:0,1:0.5,2:1:navy,3:1");
  for (const TransferPoint& point : f.points) EXPECT_EQ(point.color, *colorNamed("navy"));
  EXPECT_EQ(functionOfPoints("0:0,1:1").points[1].color, glm::dvec3(1));
}

// A preset has no number before its colon, a file may begin with "./".
TEST(PointsText, PresetsAndFiles_areNoPoints) {
  for (const char* text : {"0:0", "-1:x", "1e3:", "300:0,500:0.5"}) EXPECT_TRUE(isPointsText(text)) << text;
  for (const char* text :
       {"iso:300", "ct-bone", "./300:0", "a/3:0", "300", "", ":1", "nan:1", "inf:1", "3.json", "x:0"})
    EXPECT_FALSE(isPointsText(text)) << text;
}

TEST(PointsText, WrongTexts_areRefusedInOneLine) {
  for (const char* text : {"1:", "1:2", "1:-0.1", "1:nan", "1:0.5:", "1:0.5:oragne", "1:0.5:#ff", "1:0,", "1:0,2",
                           "1:0,,2:0", "1:0:red:1", "1:0, 2:0", "2:0,1:0", "1e301:0", "1:0,x:1"}) {
    try {
      functionOfPoints(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with("expected ")) << what;
      EXPECT_NE(what.find(", found "), std::string::npos) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
  }
}

TEST(PointsText, AJobsText_mayBePoints) {
  const auto choice = [](const std::string& text) {
    return parseJob(R"({"kiln": 2, "volume": "a", "transferFunction": ")" + text + "\"}", "jobs/job.json")
        .picture.transfer_function;
  };
  EXPECT_EQ(std::get<TransferFunction>(choice("300:0,500:0.5:#f80")).points[1].opacity, 0.5);
  EXPECT_EQ(std::get<std::filesystem::path>(choice("./300:0")), "jobs/./300:0");
  try {
    choice("300:0,500:5");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("job.json: line 1, transferFunction: expected points VALUE:OPACITY"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace kiln
