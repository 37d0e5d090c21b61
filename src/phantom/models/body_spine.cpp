// The axial skeleton below the skull: 24 vertebrae with discs, sacrum and coccyx, 12 pairs of ribs with cartilages,
// breast bone, and the spinal canal. A vertebra or a rib is one row of a table.
#include <array>
#include <glm/geometric.hpp>
#include <string>

#include "phantom/models/body.h"

namespace kiln::phantom {
namespace {

using Shapes = std::vector<ShapeSpec>;

// Centre of the vertebral body (x is 0), half width, depth and height, and lengths of the processes.
struct Vertebra {
  const char* name;
  double y, z, half_width, half_depth, half_height;
  double spine, spine_drop, transverse;
};

constexpr std::array<Vertebra, 24> kVertebrae = {{
    {"atlas (C1)", 18, 1668, 9, 6, 5, 16, 0, 36},          {"axis (C2)", 20, 1651, 10, 8, 8, 26, 4, 26},
    {"vertebra C3", 21, 1633, 11, 8.5, 7, 22, 4, 26},      {"vertebra C4", 21, 1615, 11, 8.5, 7, 22, 4, 26},
    {"vertebra C5", 22, 1597, 12, 8.5, 7, 24, 5, 27},      {"vertebra C6", 25, 1579, 12, 8.5, 7, 28, 6, 28},
    {"vertebra C7", 30, 1561, 13, 9, 7.5, 36, 10, 32},     {"vertebra T1", 36, 1541, 14, 9.5, 8, 36, 16, 34},
    {"vertebra T2", 42, 1520, 14, 10, 8.5, 31, 20, 33},    {"vertebra T3", 48, 1498, 14, 11, 9, 29, 24, 32},
    {"vertebra T4", 53, 1475, 14, 12, 9, 27, 27, 32},      {"vertebra T5", 57, 1451, 14, 12.5, 9.5, 25, 30, 31},
    {"vertebra T6", 60, 1426, 14.5, 13, 10, 24, 31, 31},   {"vertebra T7", 61, 1400, 15, 13.5, 10.5, 24, 31, 31},
    {"vertebra T8", 61, 1373, 15.5, 14, 10.5, 24, 30, 30}, {"vertebra T9", 60, 1345, 16, 14.5, 11, 24, 27, 29},
    {"vertebra T10", 57, 1317, 17, 15, 11.5, 25, 22, 28},  {"vertebra T11", 53, 1287, 18, 15.5, 12, 26, 16, 25},
    {"vertebra T12", 48, 1256, 19, 16, 12.5, 28, 10, 24},  {"vertebra L1", 43, 1222, 20, 16.5, 13.5, 31, 6, 36},
    {"vertebra L2", 38, 1186, 21, 17, 14, 32, 5, 40},      {"vertebra L3", 34, 1149, 22, 17.5, 14.5, 33, 5, 44},
    {"vertebra L4", 33, 1111, 23, 17.5, 14.5, 32, 5, 42},  {"vertebra L5", 37, 1074, 24, 17.5, 14, 28, 6, 42},
}};

glm::dvec3 bodyOf(const Vertebra& v) { return {0, v.y, v.z}; }
// Position of the canal behind the vertebral body.
glm::dvec3 canalOf(const Vertebra& v) { return {0, v.y + v.half_depth + 8, v.z - 1}; }

// The plate at the top or bottom of a vertebral body.
ShapeSpec plate(const Vertebra& v, double side) {
  const double x = 0.36 * v.half_width, z = v.z + side * 0.62 * v.half_height, radius = 0.64 * v.half_width;
  return cone({-x, v.y, z}, {x, v.y, z}, radius, radius)
      .flat({0, 0, 1}, 0.55 * v.half_height / v.half_width)
      .shell(1.2)
      .blend(3);
}

Shapes shapesOf(const Vertebra& v) {
  const double arch = v.half_depth + 9;  // from the centre of the body to the centre of the canal
  const double thick = 3.2 + 0.08 * v.half_width;
  Shapes out = {
      ellipsoid(bodyOf(v), {v.half_width, v.half_depth, 1.22 * v.half_height}).shell(1.3),
      plate(v, 1),
      plate(v, -1),
      cone({0, v.y + arch + 8, v.z - 2}, {0, v.y + arch + v.spine, v.z - 2 - v.spine_drop}, thick + 1, thick - 0.5)
          .flat({1, 0, 0}, 0.75)
          .shell(1.4)
          .blend(4),
  };
  const Shapes arches = bothSides({
      // Pedicle, lamina, joint, transverse process.
      cone({8, v.y + 0.7 * v.half_depth, v.z + 2}, {11, v.y + arch, v.z}, 4, 4).shell(1.3).blend(3),
      cone({11, v.y + arch, v.z}, {2, v.y + arch + 9, v.z - 3}, 4, 4).shell(1.3).blend(3),
      cone({12, v.y + arch - 1, v.z + v.half_height}, {12, v.y + arch + 1, v.z - v.half_height - 2}, 4, 4)
          .shell(1.2)
          .blend(3),
      cone({11, v.y + arch - 2, v.z}, {v.transverse, v.y + arch + 3, v.z + 1}, 4.6, 3.6).shell(1.3).blend(4),
  });
  out.insert(out.end(), arches.begin(), arches.end());
  return out;
}

PartSpec discs() {
  Shapes shapes;
  for (std::size_t i = 1; i + 1 < kVertebrae.size(); ++i) {
    const Vertebra &above = kVertebrae[i], &below = kVertebrae[i + 1];
    const glm::dvec3 middle = 0.5 * (bodyOf(above) + bodyOf(below));
    shapes.push_back(ellipsoid(middle, {0.95 * below.half_width, 0.95 * below.half_depth, 0.75 * below.half_height}));
  }
  const Vertebra& last = kVertebrae.back();
  shapes.push_back(ellipsoid({0, last.y + 5, last.z - 20}, {23, 16, 8}));
  return {"intervertebral discs", filledWith(Tissue::kCartilage), shapes};
}

PartSpec sacrum() {
  Shapes shapes = {ellipsoid({0, 50, 1036}, {30, 17, 17}).shell(1.5)};
  const Shapes wings = bothSides({
      cone({14, 58, 1032}, {46, 62, 1024}, 18, 17).flat({0, 1, 0.3}, 0.72).shell(1.5).blend(8),
      cone({28, 64, 1015}, {10, 86, 955}, 22, 9).flat({0, 1, 0.4}, 0.5).shell(1.5).blend(8),
  });
  shapes.insert(shapes.end(), wings.begin(), wings.end());
  shapes.push_back(cone({0, 66, 1012}, {0, 92, 940}, 22, 9).flat({0, 1, 0.4}, 0.55).shell(1.5).blend(8));
  shapes.push_back(cone({0, 82, 1020}, {0, 102, 960}, 5, 4).shell(1.2).blend(6));
  return {"sacrum", kBone, shapes};
}

// A rib: half width and position of its farthest point, front end of the bone, and end of its cartilage (none for
// floating ribs).
struct Rib {
  double half_width, side_y, side_z;
  glm::dvec3 front;
  glm::dvec3 breast_bone;
  double radius;
};

const std::array<Rib, 12>& ribTable() {
  static const std::array<Rib, 12> ribs = {{
      {62, 22, 1528, {42, -26, 1500}, {20, -44, 1490}, 5.5},
      {90, 24, 1500, {56, -46, 1470}, {22, -62, 1456}, 5.5},
      {110, 20, 1468, {66, -62, 1438}, {19, -74, 1428}, 5.6},
      {123, 18, 1438, {74, -70, 1406}, {18, -81, 1404}, 5.8},
      {131, 16, 1408, {80, -76, 1372}, {17, -86, 1382}, 5.8},
      {136, 14, 1378, {87, -78, 1336}, {16, -89, 1364}, 5.8},
      {138, 14, 1348, {94, -75, 1298}, {13, -90, 1350}, 5.8},
      {138, 14, 1316, {101, -66, 1266}, {46, -86, 1300}, 5.6},
      {135, 16, 1282, {107, -54, 1236}, {66, -80, 1268}, 5.5},
      {129, 20, 1248, {112, -38, 1206}, {84, -68, 1238}, 5.4},
      {120, 26, 1216, {122, -4, 1180}, {0, 0, 0}, 5.0},
      {98, 52, 1196, {106, 40, 1176}, {0, 0, 0}, 4.6},
  }};
  return ribs;
}

void addRibs(PartList& parts) {
  for (std::size_t i = 0; i < 12; ++i) {
    const Rib& rib = ribTable()[i];
    const Vertebra& v = kVertebrae[i + 7];
    const double back = std::min(v.y + v.half_depth + 22, 96.0);
    const double angle = 0.62 * rib.half_width;
    const bool floats = rib.breast_bone.z == 0;
    std::vector<glm::dvec3> knots = {
        {v.half_width - 2, v.y + 5, v.z + 4},
        {v.transverse - 4, v.y + v.half_depth + 6, v.z + 5},
        {std::max(angle, v.transverse + 8), back, v.z - 0.25 * (v.z - rib.side_z) - 3},
        {0.93 * rib.half_width, 0.5 * (back + rib.side_y) + 6, 0.45 * v.z + 0.55 * rib.side_z},
        {rib.half_width, rib.side_y - 6, rib.side_z - 12},
    };
    if (!floats) knots.push_back(0.5 * (knots.back() + rib.front) + glm::dvec3(0.10 * rib.half_width, -6, 0));
    knots.push_back(rib.front);
    const std::string number = std::to_string(i + 1);
    Shapes bone = chain(curve(knots, 3), rib.radius - 0.6, rib.radius);
    for (ShapeSpec& shape : bone) shape.shell_mm = 1.3;
    addPair(parts, "rib " + number, kBone, bone);
    if (floats) continue;
    const glm::dvec3 bend = i < 6 ? 0.5 * (rib.front + rib.breast_bone) + glm::dvec3(0, -4, 0)
                                  : glm::dvec3(0.72 * rib.front.x + 0.28 * rib.breast_bone.x, rib.front.y - 10,
                                               rib.front.z + 0.12 * (rib.breast_bone.z - rib.front.z));
    addPair(parts, "costal cartilage " + number, filledWith(Tissue::kCartilage),
            chain(curve({rib.front, bend, rib.breast_bone}, 3), rib.radius - 0.2, rib.radius - 0.8));
  }
}

PartSpec breastBone() {
  return {"sternum",
          kBone,
          {cone({-13, -44, 1494}, {13, -44, 1494}, 9, 9).flat({0, 1, 0.4}, 0.75).shell(1.4),
           cone({0, -48, 1486}, {0, -62, 1452}, 22, 15).flat({0, 1, 0.4}, 0.42).shell(1.4).blend(6),
           cone({0, -66, 1444}, {0, -88, 1358}, 14, 18).flat({0, 1, 0.2}, 0.40).shell(1.4).blend(4),
           cone({0, -89, 1350}, {0, -86, 1318}, 9, 4).flat({0, 1, 0}, 0.5).shell(1.2).blend(4)}};
}

std::vector<glm::dvec3> canalPoints() {
  std::vector<glm::dvec3> points = {{0, 34, 1690}};
  for (const Vertebra& v : kVertebrae) points.push_back(canalOf(v));
  points.push_back({0, 74, 1030});
  return points;
}

}  // namespace

PartList spineAndRibs() {
  PartList parts = {discs()};
  for (const Vertebra& v : kVertebrae) parts.push_back({v.name, kBone, shapesOf(v)});
  parts.push_back(sacrum());
  parts.push_back({"coccyx", kBone, {cone({0, 92, 938}, {0, 84, 905}, 7, 4).shell(1.2)}});
  addRibs(parts);
  parts.push_back(breastBone());
  return parts;
}

PartList spinalCord() {
  const std::vector<glm::dvec3> points = canalPoints();
  return {{"spinal canal", filledWith(Tissue::kFluid), chain(points, 7.5, 8)},
          {"spinal cord", filledWith(Tissue::kWhiteMatter), chain({points.begin(), points.begin() + 21}, 5, 3.5)}};
}

}  // namespace kiln::phantom
