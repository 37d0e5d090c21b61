// Hands and feet. The joints of a finger or toe define both its flesh and its bones. The hand hangs beside the thigh,
// palm inwards (-x), thumb forward; the foot points forward and stands on z = 22 mm.
#include <glm/geometric.hpp>
#include <string>

#include "phantom/models/body.h"

namespace kiln::phantom {
namespace {

using Shapes = std::vector<ShapeSpec>;

// Base of the metacarpal, joints, tip: from the wrist or ankle outwards.
struct Digit {
  const char* name;
  std::vector<glm::dvec3> joints;
  double flesh_root, flesh_tip;  // radii at the first joint of the free finger and at the tip
};

const std::vector<Digit>& fingers() {
  static const std::vector<Digit> digits = {
      {"thumb", {{258, -32, 905}, {253, -58, 868}, {249, -73, 836}, {247, -81, 810}}, 11.5, 9},
      {"index finger",
       {{264, -30, 905}, {268.5, -46, 834}, {267, -57, 790}, {261, -61, 764}, {254, -63, 744}},
       9.8,
       7.6},
      {"middle finger", {{265, -17, 905}, {271, -25, 829}, {269, -29, 780}, {262, -31, 751}, {254, -32, 729}}, 10, 7.8},
      {"ring finger", {{265, -4, 905}, {270, -2, 833}, {267, 0, 787}, {260, 1, 759}, {252, 1, 738}}, 9.5, 7.4},
      {"little finger", {{264, 8, 907}, {267, 19, 842}, {263, 26, 806}, {257, 29, 785}, {250, 30, 768}}, 8.6, 6.8},
  };
  return digits;
}

const std::vector<Digit>& toes() {
  static const std::vector<Digit> digits = {
      {"big toe", {{80, -30, 62}, {73, -96, 40}, {72, -124, 37}, {73, -146, 35}}, 14.5, 12.5},
      {"second toe", {{90, -32, 62}, {93, -100, 39}, {95, -124, 40}, {96, -138, 35}, {97, -150, 31}}, 9.8, 8.6},
      {"third toe", {{97, -30, 58}, {107, -94, 37}, {110, -115, 38}, {112, -128, 34}, {113, -139, 30}}, 9.4, 8.2},
      {"fourth toe", {{105, -22, 52}, {118, -84, 35}, {122, -103, 36}, {124, -115, 32}, {125, -125, 29}}, 9, 7.8},
      {"little toe", {{113, -15, 46}, {128, -70, 33}, {132, -88, 33}, {134, -98, 31}, {135, -107, 29}}, 8.8, 7.6},
  };
  return digits;
}

Shapes handFlesh() {
  Shapes out = {
      // Palm, the ball of the thumb, the edge of the hand.
      cone({264, -11, 908}, {269, -14, 848}, 29, 38).flat({1, 0.05, 0}, 0.40).shell(3.5).blend(12),
      cone({259, -32, 898}, {256, -50, 866}, 16, 14).shell(4).blend(12),
      cone({262, 10, 895}, {266, 14, 850}, 14, 13).shell(4).blend(10),
  };
  for (const Digit& digit : fingers()) {
    const Shapes free = chain({digit.joints.begin() + 1, digit.joints.end()}, digit.flesh_root, digit.flesh_tip);
    for (const ShapeSpec& shape : free) out.push_back(shape.shell(3).blend(3));
  }
  return out;
}

Shapes footFlesh() {
  Shapes out = {
      // Heel, the back of the foot, instep, outer edge, ball.
      ellipsoid({90, 66, 54}, {30, 36, 33}).shell(9).blend(22),
      cone({90, 34, 90}, {92, -40, 64}, 33, 28).shell(5).blend(24),
      cone({86, -20, 62}, {84, -92, 42}, 26, 19).shell(5).blend(20),
      cone({112, 40, 40}, {124, -70, 37}, 17, 14.5).shell(6).blend(16),
      cone({78, -94, 39}, {124, -74, 36}, 17, 13.5).shell(5).blend(14),
      cone({106, -40, 52}, {106, -88, 40}, 24, 17).shell(5).blend(16),
  };
  for (const Digit& digit : toes()) {
    const Shapes free = chain({digit.joints.begin() + 1, digit.joints.end()}, digit.flesh_root, digit.flesh_tip);
    for (const ShapeSpec& shape : free) out.push_back(shape.shell(3).blend(4));
  }
  return out;
}

// A long bone of a digit: shaft and heads.
Shapes smallBone(const glm::dvec3& a, const glm::dvec3& b, double radius) {
  const glm::dvec3 along = b - a;
  const glm::dvec3 from = a + 0.10 * along, to = b - 0.10 * along;
  const glm::dvec3 middle = 0.5 * (from + to);
  return {cone(from, middle, 1.25 * radius, 0.85 * radius).shell(1.2),
          cone(middle, to, 0.85 * radius, 1.2 * radius).shell(1.2).blend(2)};
}

void addDigitBones(PartList& parts, const Digit& digit, const char* root, double radius) {
  addPair(parts, std::string(root) + " of the " + digit.name, kBone,
          smallBone(digit.joints[0], digit.joints[1], 1.15 * radius));
  Shapes phalanges;
  for (std::size_t i = 1; i + 1 < digit.joints.size(); ++i) {
    const double taper = 1 - 0.14 * static_cast<double>(i);
    const Shapes bone = smallBone(digit.joints[i], digit.joints[i + 1], taper * radius);
    phalanges.insert(phalanges.end(), bone.begin(), bone.end());
  }
  addPair(parts, std::string("phalanges of the ") + digit.name, kBone, phalanges);
}

void addCarpals(PartList& parts) {
  const struct {
    const char* name;
    glm::dvec3 centre, half;
  } kRows[] = {
      {"scaphoid", {261, -24, 925}, {6.5, 8, 9}},  {"lunate", {262, -11, 928}, {7, 7.5, 8}},
      {"triquetrum", {262, 2, 926}, {7, 7, 8}},    {"pisiform", {256, 5, 922}, {5, 5, 6}},
      {"trapezium", {259, -31, 911}, {6, 6.5, 6}}, {"trapezoid", {264, -22, 911}, {6.5, 5.5, 6}},
      {"capitate", {264, -11, 912}, {7, 7, 9}},    {"hamate", {263, 3, 912}, {7.5, 7.5, 8}},
  };
  for (const auto& row : kRows) addPair(parts, row.name, kBone, {ellipsoid(row.centre, row.half).shell(1.2)});
}

void addTarsals(PartList& parts) {
  addPair(
      parts, "talus", kBone,
      {ellipsoid({90, 26, 98}, {18, 24, 15}).shell(1.5), cone({89, 6, 88}, {88, -8, 82}, 12, 12).shell(1.5).blend(8)});
  addPair(parts, "calcaneus", kBone,
          {cone({94, 18, 66}, {91, 76, 56}, 15, 17).shell(1.5),
           cone({98, 4, 62}, {94, 20, 62}, 12, 14).shell(1.5).blend(8), ball({82, 28, 74}, 8).shell(1.5).blend(6)});
  const struct {
    const char* name;
    glm::dvec3 centre, half;
  } kRows[] = {
      {"navicular", {86, -17, 78}, {16, 7, 11}},         {"cuboid", {106, -8, 56}, {10, 15, 10}},
      {"medial cuneiform", {80, -30, 66}, {7, 10, 11}},  {"intermediate cuneiform", {89, -30, 70}, {5.5, 8, 8}},
      {"lateral cuneiform", {97, -28, 65}, {6, 9, 8.5}},
  };
  for (const auto& row : kRows) addPair(parts, row.name, kBone, {ellipsoid(row.centre, row.half).shell(1.2)});
}

}  // namespace

std::vector<ShapeSpec> handAndFootFlesh() {
  Shapes out = handFlesh();
  const Shapes foot = footFlesh();
  out.insert(out.end(), foot.begin(), foot.end());
  return out;
}

PartList handAndFootBones() {
  PartList parts;
  addCarpals(parts);
  for (const Digit& digit : fingers()) addDigitBones(parts, digit, "metacarpal", 4.4);
  addTarsals(parts);
  for (const Digit& digit : toes()) {
    addDigitBones(parts, digit, "metatarsal", std::string(digit.name) == "big toe" ? 6.6 : 4.4);
  }
  return parts;
}

}  // namespace kiln::phantom
