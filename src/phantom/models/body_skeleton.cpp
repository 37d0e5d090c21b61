// Shoulders, arms, pelvis and legs down to wrist and ankle. Long bones have thick cortical walls along the shaft and
// thin walls at the ends; blades are flattened cones.
#include "phantom/models/body.h"

namespace kiln::phantom {
namespace {

void addShoulder(PartList& parts) {
  addPair(
      parts, "clavicle", kBone,
      with(chain(curve({{18, -46, 1494}, {64, -46, 1499}, {118, -12, 1504}, {174, 14, 1506}}, 3), 7.5, 6.5), 2, 1.8));
  // The blade between its upper inner, lower and outer corners; its ridge behind; acromion, coracoid, socket.
  const glm::dvec3 normal{0.44, 0.88, 0.17};
  addPair(parts, "scapula", kBone,
          {cone({78, 82, 1484}, {84, 94, 1420}, 13, 16).flat(normal, 0.28).shell(1.4),
           cone({84, 94, 1420}, {104, 92, 1362}, 17, 9).flat(normal, 0.30).shell(1.4).blend(5),
           cone({104, 90, 1372}, {172, 40, 1452}, 10, 12).flat(normal, 0.42).shell(1.4).blend(5),
           cone({84, 82, 1478}, {165, 42, 1488}, 13, 12).flat(normal, 0.28).shell(1.4).blend(5),
           cone({98, 84, 1430}, {150, 54, 1460}, 34, 22).flat(normal, 0.10).shell(1.2).blend(5),
           cone({80, 92, 1462}, {150, 62, 1488}, 4.5, 6).shell(1.4).blend(5),
           cone({150, 62, 1488}, {190, 32, 1508}, 6.5, 8.5).flat({0, 0, 1}, 0.7).shell(1.4).blend(5),
           cone({190, 32, 1508}, {186, 12, 1507}, 9, 7).flat({0, 0, 1}, 0.7).shell(1.4).blend(5),
           cone({166, 30, 1484}, {160, -4, 1488}, 7, 6).shell(1.4).blend(5),
           ellipsoid({173, 28, 1466}, {8, 13, 18}).shell(1.5).blend(6)});
}

void addArm(PartList& parts) {
  addPair(parts, "humerus", kBone,
          {ball({193, 20, 1474}, 23).shell(1.6), ellipsoid({206, 16, 1466}, {15, 17, 20}).shell(1.8).blend(8),
           cone({204, 20, 1456}, {222, 24, 1330}, 15, 11).shell(4).blend(10),
           cone({222, 24, 1330}, {238, 27, 1215}, 11, 11).shell(4.2).blend(4),
           cone({237, 27, 1222}, {240, 28, 1190}, 11, 16).flat({0, 1, 0}, 0.62).shell(2.6).blend(6),
           cone({223, 28, 1188}, {257, 27, 1184}, 10, 10).shell(1.8).blend(6)});
  addPair(
      parts, "ulna", kBone,
      {cone({238, 44, 1196}, {238, 42, 1170}, 10, 10).shell(1.8),
       cone({239, 40, 1174}, {252, 16, 1050}, 9.5, 6.6).shell(2.6).blend(5),
       cone({252, 16, 1050}, {261, 6, 948}, 6.6, 5.4).shell(2.4).blend(3), ball({261, 5, 945}, 7).shell(1.4).blend(3)});
  addPair(parts, "radius", kBone,
          {ellipsoid({254, 14, 1172}, {10, 10, 7}).shell(1.6),
           cone({254, 13, 1166}, {256, 4, 1080}, 6.4, 7).shell(2.4).blend(4),
           cone({256, 4, 1080}, {262, -16, 958}, 7, 8).shell(2.6).blend(3),
           cone({262, -16, 958}, {262, -19, 942}, 9.5, 12).flat({1, 0, 0}, 0.75).shell(1.6).blend(5)});
}

void addPelvis(PartList& parts) {
  // Blade of the ilium as a fan from the socket, its crest, pubis and ischium around the obturator foramen.
  const glm::dvec3 socket{92, 14, 952}, normal{0.88, 0.46, 0.1};
  std::vector<ShapeSpec> shapes = {
      cone({96, 14, 968}, {118, -26, 1036}, 22, 22).flat(normal, 0.24).shell(1.6),
      cone({94, 22, 968}, {124, 4, 1052}, 22, 26).flat(normal, 0.20).shell(1.6).blend(6),
      cone({92, 30, 968}, {102, 42, 1050}, 22, 32).flat(normal, 0.22).shell(1.6).blend(6),
      cone({88, 36, 966}, {68, 70, 1038}, 22, 30).flat(normal, 0.26).shell(1.8).blend(6),
      ellipsoid({98, 12, 950}, {24, 27, 28}).shell(2).blend(8),
      cone({90, -10, 946}, {46, -54, 930}, 10, 8.5).shell(2).blend(8),
      cone({46, -54, 930}, {10, -62, 922}, 9, 10).flat({0, 1, 0}, 0.8).shell(1.8).blend(5),
      cone({10, -62, 922}, {10, -56, 898}, 9, 8).shell(1.8).blend(4),
      cone({11, -54, 898}, {50, 10, 862}, 6.5, 7.5).shell(1.8).blend(4),
      cone({58, 24, 866}, {84, 30, 930}, 15, 15).shell(2).blend(8),
      cone({50, 10, 862}, {60, 26, 866}, 9, 14).shell(1.8).blend(5),
      cone({72, 40, 930}, {56, 58, 934}, 7, 4).shell(1.5).blend(5),
  };
  const auto crest = with(
      chain(curve({{120, -52, 1028}, {134, -34, 1058}, {138, 0, 1078}, {118, 42, 1084}, {76, 74, 1064}, {52, 86, 1030}},
                  2),
            7, 7.5),
      5, 1.6);
  shapes.insert(shapes.end(), crest.begin(), crest.end());
  addPair(parts, "hip bone", kBone, shapes);
  parts.push_back({"pubic symphysis", filledWith(Tissue::kCartilage), {ellipsoid({0, -60, 912}, {4, 8, 17})}});
}

void addLeg(PartList& parts) {
  addPair(
      parts, "femur", kBone,
      {ball({94, 12, 952}, 24).shell(1.4), cone({98, 13, 949}, {138, 20, 920}, 15, 17).shell(2).blend(7),
       cone({147, 22, 944}, {146, 24, 915}, 15, 18).shell(1.8).blend(10), ball({124, 32, 886}, 11).shell(1.8).blend(10),
       cone({141, 20, 905}, {124, 8, 760}, 19, 14.5).shell(5.5).blend(10),
       cone({124, 8, 760}, {102, 8, 610}, 14.5, 15.5).shell(6).blend(4),
       cone({101, 8, 615}, {92, 8, 550}, 15.5, 27).flat({0, 1, 0}, 0.75).shell(2.4).blend(8),
       ellipsoid({69, 16, 532}, {20, 30, 24}).shell(1.5).blend(8),
       ellipsoid({114, 16, 532}, {20, 29, 23}).shell(1.5).blend(8)});
  addPair(parts, "patella", kBone, {ellipsoid({92, -37, 530}, {20, 9, 22}).shell(1.8)});
  addPair(parts, "tibia", kBone,
          {cone({72, 10, 494}, {110, 10, 494}, 19, 19).flat({0, 0, 1}, 0.72).shell(1.5),
           cone({91, 8, 492}, {90, 4, 430}, 26, 15).flat({0, 1, 0}, 0.9).shell(2).blend(8),
           ball({92, -16, 462}, 9).shell(2).blend(10), cone({90, 4, 435}, {84, 14, 260}, 15, 12).shell(5).blend(5),
           cone({84, 14, 260}, {86, 27, 140}, 12, 12.5).shell(4).blend(4),
           cone({86, 27, 142}, {88, 28, 124}, 13, 19).shell(1.8).blend(6),
           cone({70, 30, 128}, {67, 30, 104}, 9, 7).shell(1.5).blend(6)});
  addPair(parts, "fibula", kBone,
          {ellipsoid({124, 30, 482}, {9, 10, 12}).shell(1.5),
           cone({123, 31, 476}, {112, 40, 280}, 6, 5.6).shell(2.2).blend(5),
           cone({112, 40, 280}, {112, 41, 125}, 5.6, 6.5).shell(2.2).blend(3),
           ellipsoid({113, 40, 104}, {7, 9, 15}).shell(1.5).blend(5)});
  // The cartilages of knee and hip lie between bones, which have higher precedence.
  addPair(parts, "patellar ligament", filledWith(Tissue::kTendon),
          {cone({92, -40, 512}, {92, -24, 468}, 9, 8).flat({0, 1, 0}, 0.45)});
  addPair(parts, "Achilles tendon", filledWith(Tissue::kTendon),
          {cone({89, 56, 230}, {91, 86, 75}, 8, 9).flat({0, 1, 0}, 0.5)});
}

}  // namespace

PartList limbBones() {
  PartList parts;
  addShoulder(parts);
  addArm(parts);
  addPelvis(parts);
  addLeg(parts);
  return parts;
}

}  // namespace kiln::phantom
