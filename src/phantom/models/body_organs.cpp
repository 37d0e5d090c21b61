// Contents of the trunk: cavities lined with fat (so organs do not float in muscle), organs, large vessels, and all
// enclosed air: windpipe, bronchi, nose, sinuses, ears, stomach, bowel. No air reaches the outside: nostrils and mouth
// are closed.
#include "phantom/models/body.h"

namespace kiln::phantom {
namespace {

using Shapes = std::vector<ShapeSpec>;
using Points = std::vector<glm::dvec3>;

// A tube along the smooth curve through the points.
Shapes tube(const Points& points, int steps, double first_radius, double last_radius, double shell = 0) {
  return with(chain(curve(points, steps), first_radius, last_radius), 0.8 * last_radius, shell);
}

constexpr Layers kHollowGut = shellOf(Tissue::kGutWall, Tissue::kGutContent);
constexpr Layers kGassyGut = shellOf(Tissue::kGutWall, Tissue::kAir);
constexpr Layers kArtery = shellOf(Tissue::kVessel, Tissue::kBlood);

void addChest(PartList& parts) {
  const auto addBranches = [&](const char* name, double side) {
    Shapes tree;
    const auto branch = [&](const Points& points, double a, double b) {
      Shapes pieces = with(chain(curve(points, 3), a, b), 3, 0);
      for (ShapeSpec& piece : pieces) tree.push_back(side < 0 ? piece.mirrored() : piece);
    };
    branch({{20, 14, 1400}, {50, 20, 1410}, {78, 18, 1440}, {88, 12, 1476}}, 7, 1.5);
    branch({{20, 14, 1396}, {52, -4, 1392}, {80, -36, 1396}, {92, -52, 1410}}, 6, 1.5);
    branch({{20, 16, 1394}, {50, 26, 1376}, {82, 36, 1330}, {98, 44, 1280}}, 7.5, 1.5);
    branch({{44, 24, 1380}, {62, 46, 1368}, {84, 66, 1372}}, 4.5, 1.5);
    branch({{46, 22, 1378}, {64, 2, 1340}, {84, -22, 1310}}, 4.5, 1.5);
    branch({{66, 30, 1352}, {88, 24, 1350}, {112, 20, 1356}}, 3.5, 1.3);
    branch({{70, 18, 1430}, {90, 32, 1436}, {102, 44, 1430}}, 3.5, 1.3);
    branch({{76, 34, 1338}, {74, 58, 1312}, {76, 72, 1280}}, 3.5, 1.3);
    branch({{86, 37, 1322}, {108, 28, 1306}, {118, 22, 1280}}, 3.2, 1.3);
    parts.push_back({name, filledWith(Tissue::kBlood), tree});
  };
  addBranches("vessels of the left lung", 1);
  addBranches("vessels of the right lung", -1);
  parts.push_back({"heart",
                   shellOf(Tissue::kHeart, Tissue::kBlood),
                   {ellipsoid({18, -34, 1352}, {46, 36, 54}).turned({-0.55, 0.25, 0.8}, {0, 1, 0}).shell(12),
                    ellipsoid({-18, -16, 1372}, {30, 30, 38}).shell(4).blend(16),
                    ellipsoid({10, -4, 1392}, {36, 24, 24}).shell(4).blend(14)}});
  parts.push_back({"septum of the heart",
                   filledWith(Tissue::kHeart),
                   {cone({4, -36, 1378}, {34, -52, 1330}, 18, 14).flat({0.75, -0.5, -0.35}, 0.28)}});
}

void addUpperAbdomen(PartList& parts) {
  parts.push_back({"liver",
                   filledWith(Tissue::kLiver),
                   {ellipsoid({-66, -4, 1244}, {70, 72, 72}), ellipsoid({-86, 8, 1206}, {42, 56, 60}).blend(24),
                    ellipsoid({6, -40, 1258}, {66, 38, 34}).blend(30)}});
  parts.push_back({"gallbladder",
                   shellOf(Tissue::kGutWall, Tissue::kFluid),
                   {cone({-46, -46, 1196}, {-40, -26, 1222}, 14, 8).shell(2)}});
  parts.push_back(
      {"spleen", filledWith(Tissue::kSpleen), {ellipsoid({102, 44, 1244}, {22, 42, 54}).turned({0.1, -0.35, 1})}});
  parts.push_back({"stomach",
                   kHollowGut,
                   {ellipsoid({62, -2, 1262}, {38, 40, 44}).shell(4),
                    cone({62, -14, 1236}, {44, -42, 1188}, 32, 24).shell(4).blend(16),
                    cone({44, -42, 1188}, {0, -44, 1180}, 23, 14).shell(4).blend(12)}});
  parts.push_back({"pancreas", filledWith(Tissue::kPancreas),
                   tube({{-30, -8, 1172}, {0, -20, 1190}, {40, 0, 1204}, {78, 24, 1214}}, 3, 15, 9)});
  addPair(parts, "kidney", shellOf(Tissue::kKidneyCortex, Tissue::kKidneyMedulla),
          {ellipsoid({62, 46, 1184}, {26, 22, 54}).turned({-0.22, -0.1, 1}).shell(9),
           ellipsoid({36, 40, 1178}, {14, 14, 22}).carve().shell(9).blend(8)});
  addPair(parts, "renal pelvis", filledWith(Tissue::kFluid), {ellipsoid({48, 42, 1180}, {10, 7, 18})});
  addPair(parts, "adrenal gland", filledWith(Tissue::kGland), {cone({40, 40, 1244}, {54, 44, 1238}, 6, 4)});
  addPair(parts, "ureter", filledWith(Tissue::kFluid),
          tube({{42, 38, 1160}, {38, 10, 1080}, {42, 20, 1010}, {26, 8, 950}}, 3, 2.5, 2.5));
}

void addBowel(PartList& parts) {
  parts.push_back(
      {"duodenum", kHollowGut,
       tube({{-6, -44, 1180}, {-42, -30, 1182}, {-50, -12, 1140}, {-20, -14, 1116}, {24, -22, 1130}}, 3, 13, 13, 2.5)});
  // The small bowel as a winding of loops, row under row.
  Points loops;
  for (int row = 0; row < 6; ++row) {
    const double z = 1130 - 27 * row, reach = row < 4 ? 66 - 3 * row : 46 - 10 * (row - 4);
    for (int step = 0; step <= 6; ++step) {
      const double t = row % 2 == 0 ? step : 6 - step;
      const double x = reach * (t / 3 - 1);
      loops.push_back({x, (step % 2 == 0 ? -68 : -26) + 6 * (row % 3), z - 4 * step / 6.0});
    }
  }
  parts.push_back({"small bowel", kHollowGut, tube(loops, 2, 13.5, 13.5, 2.5)});
  Shapes colon;
  const auto haustra = [&](const Points& points, double radius) {
    const Points path = curve(points, 4);
    for (std::size_t i = 0; i < path.size(); ++i)
      colon.push_back(ball(path[i], i % 2 == 0 ? radius : 0.86 * radius).shell(3).blend(6));
  };
  haustra({{-92, 0, 1030}, {-102, 8, 1080}, {-104, 10, 1130}, {-98, 2, 1168}}, 24);
  haustra({{-98, 2, 1168}, {-64, -52, 1160}, {0, -72, 1146}, {60, -52, 1166}, {98, 14, 1204}}, 20);
  haustra(
      {{98, 14, 1204}, {108, 30, 1150}, {108, 28, 1090}, {100, 16, 1030}, {76, 10, 990}, {36, 30, 984}, {8, 46, 972}},
      17);
  parts.push_back({"colon", kHollowGut, colon});
  parts.push_back(
      {"appendix", filledWith(Tissue::kGutWall), tube({{-90, 2, 1016}, {-74, 10, 1002}, {-66, 4, 986}}, 2, 4, 3)});
  parts.push_back({"rectum", kHollowGut, tube({{8, 46, 972}, {0, 62, 940}, {0, 60, 900}, {0, 62, 884}}, 3, 17, 12, 3)});
}

void addPelvicOrgans(PartList& parts) {
  parts.push_back(
      {"bladder", shellOf(Tissue::kGutWall, Tissue::kFluid), {ellipsoid({0, -18, 938}, {40, 32, 34}).shell(4)}});
  parts.push_back({"prostate", filledWith(Tissue::kGland), {ellipsoid({0, -10, 896}, {20, 16, 15})}});
  addPair(parts, "psoas muscle", filledWith(Tissue::kMuscle),
          tube({{30, 44, 1214}, {40, 34, 1110}, {62, 6, 1010}, {84, -18, 950}}, 3, 12, 20));
  addPair(parts, "erector spinae", filledWith(Tissue::kMuscle),
          tube({{26, 92, 1440}, {30, 92, 1290}, {32, 80, 1130}, {26, 98, 1010}}, 3, 15, 20));
}

}  // namespace

PartList trunkCavities() {
  return {
      {"peritoneal cavity",
       filledWith(Tissue::kFat),
       {ellipsoid({0, -4, 1120}, {116, 84, 170}), ellipsoid({0, 6, 960}, {78, 62, 90}).blend(40)}},
      {"mediastinum",
       filledWith(Tissue::kFat),
       {ellipsoid({4, -10, 1370}, {52, 62, 120}), cone({0, 0, 1470}, {0, 0, 1540}, 26, 20).blend(20)}},
      {"left lung",
       filledWith(Tissue::kLung),
       {ellipsoid({74, 22, 1362}, {50, 68, 112}), ellipsoid({62, 20, 1440}, {40, 50, 72}).blend(24),
        ellipsoid({80, 30, 1296}, {46, 62, 66}).blend(24), ellipsoid({66, -34, 1372}, {42, 34, 78}).blend(20)}},
      {"right lung",
       filledWith(Tissue::kLung),
       {ellipsoid({-74, 22, 1366}, {51, 68, 110}), ellipsoid({-62, 20, 1440}, {40, 50, 72}).blend(24),
        ellipsoid({-80, 30, 1304}, {46, 62, 62}).blend(24), ellipsoid({-66, -32, 1370}, {44, 36, 80}).blend(20)}},
      // Domed into the lungs, with fat below.
      {"diaphragm",
       filledWith(Tissue::kMuscle),
       {ellipsoid({0, 4, 1236}, {124, 92, 82}), ellipsoid({-60, 0, 1250}, {60, 78, 74}).blend(20)}},
      {"fat below the diaphragm",
       filledWith(Tissue::kFat),
       {ellipsoid({0, 4, 1232}, {120, 88, 80}), ellipsoid({-60, 0, 1245}, {57, 75, 72}).blend(20)}},
  };
}

PartList organs() {
  PartList parts;
  addPelvicOrgans(parts);
  addChest(parts);
  addUpperAbdomen(parts);
  addBowel(parts);
  parts.push_back({"thyroid gland",
                   filledWith(Tissue::kGland),
                   {ellipsoid({17, -28, 1560}, {9, 11, 24}), ellipsoid({-17, -28, 1560}, {9, 11, 24}),
                    cone({-10, -36, 1554}, {10, -36, 1554}, 5, 5).blend(4)}});
  parts.push_back(
      {"esophagus", filledWith(Tissue::kGutWall),
       tube({{0, 4, 1590}, {0, 14, 1540}, {4, 34, 1460}, {10, 40, 1370}, {24, 26, 1290}, {40, 8, 1262}}, 3, 8, 9)});
  parts.push_back({"larynx",
                   filledWith(Tissue::kCartilage),
                   {cone({0, -32, 1592}, {0, -26, 1562}, 15, 13).flat({0, 1, 0}, 0.95),
                    cone({12, -28, 1598}, {0, -42, 1586}, 3.5, 4).blend(4),
                    cone({-12, -28, 1598}, {0, -42, 1586}, 3.5, 4).blend(4)}});
  return parts;
}

PartList vessels() {
  PartList parts;
  parts.push_back({"aorta", kArtery,
                   tube({{4, -20, 1398},
                         {-8, -26, 1430},
                         {0, -10, 1462},
                         {16, 20, 1462},
                         {24, 44, 1430},
                         {20, 46, 1360},
                         {10, 34, 1260},
                         {8, 14, 1170},
                         {4, 6, 1092}},
                        3, 14.5, 10, 1.8)});
  parts.push_back({"pulmonary trunk", kArtery, tube({{14, -48, 1392}, {14, -30, 1418}, {2, 6, 1412}}, 3, 12, 10, 1.5)});
  parts.push_back({"superior vena cava", filledWith(Tissue::kBlood),
                   tube({{-22, -14, 1380}, {-26, -14, 1430}, {-20, -20, 1480}}, 2, 9, 8)});
  parts.push_back({"inferior vena cava", filledWith(Tissue::kBlood),
                   tube({{-20, 2, 1350}, {-22, 16, 1270}, {-20, 16, 1170}, {-14, 10, 1086}}, 2, 11, 9)});
  parts.push_back({"portal vein", filledWith(Tissue::kBlood),
                   tube({{20, -6, 1186}, {-14, -6, 1206}, {-44, -4, 1232}, {-76, -2, 1248}}, 2, 6, 5)});
  addPair(
      parts, "iliac and femoral artery", kArtery,
      tube({{4, 6, 1092}, {26, 4, 1046}, {62, -30, 980}, {80, -46, 920}, {74, -24, 780}, {78, 28, 600}, {86, 36, 520}},
           3, 8, 4.5, 1.2));
  addPair(parts, "common carotid artery", kArtery,
          tube({{8, -14, 1470}, {20, -14, 1530}, {28, -8, 1600}, {30, 2, 1660}}, 3, 4.5, 3.5, 1));
  addPair(parts, "jugular vein", filledWith(Tissue::kBlood),
          tube({{30, -22, 1500}, {34, -14, 1550}, {38, 2, 1640}}, 3, 7, 5));
  addPair(parts, "subclavian and brachial artery", kArtery,
          tube({{10, -12, 1466}, {52, -14, 1514}, {120, -4, 1496}, {176, 12, 1440}, {212, 10, 1330}, {234, 2, 1196}}, 3,
               5.5, 3, 1));
  addPair(parts, "great saphenous vein", filledWith(Tissue::kBlood),
          tube({{72, -46, 900}, {50, -20, 720}, {52, 22, 540}, {64, 28, 300}, {68, 22, 140}}, 3, 2.6, 2));
  return parts;
}

PartList airways() {
  PartList parts;
  parts.push_back({"trachea", shellOf(Tissue::kCartilage, Tissue::kAir),
                   tube({{0, -24, 1596}, {0, -16, 1550}, {0, 6, 1490}, {0, 16, 1432}}, 3, 10.5, 10.5, 2)});
  addPair(parts, "main bronchus", shellOf(Tissue::kCartilage, Tissue::kAir),
          tube({{0, 16, 1432}, {22, 18, 1412}, {46, 20, 1396}, {64, 24, 1376}}, 3, 8.5, 4.5, 1.4));
  parts.push_back({"pharynx",
                   kAirFilled,
                   {cone({0, -4, 1684}, {0, -2, 1640}, 9, 8), cone({0, -2, 1642}, {0, -14, 1606}, 8, 7).blend(6),
                    cone({0, -14, 1606}, {0, -24, 1592}, 7, 7).blend(4)}});
  parts.push_back(
      {"nasal cavity",
       kAirFilled,
       {cone({7, -74, 1692}, {6, -18, 1692}, 6, 6).flat({0, 0, 1}, 1.5),
        cone({-7, -74, 1692}, {-6, -18, 1692}, 6, 6).flat({0, 0, 1}, 1.5).blend(1),
        cone({4.5, -74, 1700}, {4.5, -36, 1722}, 4, 3).blend(4),
        cone({-4.5, -74, 1700}, {-4.5, -36, 1722}, 4, 3).blend(4), cone({7, -88, 1697}, {7, -74, 1694}, 4, 6).blend(3),
        cone({-7, -88, 1697}, {-7, -74, 1694}, 4, 6).blend(3), cone({0, -18, 1692}, {0, -6, 1686}, 9, 9).blend(6)}});
  parts.push_back({"nasal septum", filledWith(Tissue::kCartilage), {box({0, -54, 1703}, {1.2, 27, 16}, 1)}});
  addPair(parts, "lower nasal concha", filledWith(Tissue::kMuscle), {cone({10, -68, 1692}, {9, -28, 1692}, 3, 2.6)});
  addPair(parts, "maxillary sinus", kAirFilled, {ellipsoid({29, -52, 1697}, {11, 14, 13})});
  addPair(parts, "frontal sinus", kAirFilled, {ellipsoid({13, -71, 1763}, {10, 3.4, 8})});
  addPair(parts, "sphenoid sinus", kAirFilled, {ellipsoid({7, -12, 1708}, {6, 11, 9})});
  addPair(parts, "ethmoid cells", kAirFilled,
          {cone({9, -56, 1733}, {8, -28, 1727}, 4, 4), cone({9, -44, 1724}, {8, -30, 1720}, 4, 4).blend(1)});
  addPair(parts, "mastoid cells", kAirFilled,
          {ball({55, 27, 1702}, 4.5), ball({52, 26, 1694}, 4), ball({54, 32, 1694}, 3.2), ball({50, 32, 1704}, 3.4)});
  addPair(parts, "ear canal and middle ear", kAirFilled,
          {cone({65, 8, 1720}, {46, 10, 1718}, 3.4, 3), ellipsoid({42, 10, 1718}, {4, 6, 7}).blend(2)});
  parts.push_back({"gas in the stomach",
                   kAirFilled,
                   {ellipsoid({62, -10, 1276}, {28, 26, 22}), ellipsoid({52, -32, 1244}, {18, 14, 16}).blend(8)}});
  parts.push_back({"gas in the transverse colon",
                   kAirFilled,
                   {ellipsoid({-40, -66, 1156}, {22, 9, 11}), ellipsoid({4, -76, 1149}, {24, 8, 10}),
                    ellipsoid({50, -62, 1163}, {20, 9, 11})}});
  parts.push_back({"gas in the ascending colon", kAirFilled, {ellipsoid({-101, 2, 1120}, {15, 13, 34})}});
  parts.push_back({"gas in the descending colon",
                   kAirFilled,
                   {ellipsoid({108, 22, 1134}, {9, 8, 26}), ellipsoid({105, 20, 1060}, {9, 8, 20})}});
  parts.push_back({"gas in the small bowel",
                   kAirFilled,
                   {ellipsoid({-20, -62, 1128}, {9, 7, 6}), ellipsoid({30, -58, 1102}, {8, 6, 6}),
                    ellipsoid({-34, -54, 1048}, {8, 6, 6})}});
  parts.push_back({"gas in the rectum", kAirFilled, {ellipsoid({0, 56, 926}, {8, 7, 16})}});
  return parts;
}

}  // namespace kiln::phantom
