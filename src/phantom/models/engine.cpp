// The block stands with its deck towards +z; four bores lie in line along x. Voids are parts of air after the metal;
// liners and bolts come after the voids.
#include "phantom/models/engine.h"

#include <glm/vec2.hpp>

namespace kiln::phantom {
namespace {

using Shapes = std::vector<ShapeSpec>;

constexpr double kBoreX[4] = {-81, -27, 27, 81};
constexpr double kDeck = 47, kFloor = -47;
constexpr Layers kMetal = filledWith(Tissue::kAluminium), kVoid = filledWith(Tissue::kAir),
                 kSteel = filledWith(Tissue::kIron);

ShapeSpec upright(double x, double y, double z_lo, double z_hi, double radius, double rounding = 0) {
  return cylinder({x, y, z_lo}, {x, y, z_hi}, radius, rounding);
}

Shapes casting() {
  Shapes out = {
      // The block, its deck and its base flange.
      box({0, 0, 4}, {114, 44, 42}, 5),
      box({0, 0, 40}, {120, 62, 7}, 3).blend(4),
      box({0, 0, -38}, {122, 86, 8}, 4).blend(6),
      // Side pods: the water jacket's cover, the oil filter's foot, the starter's seat, the bell housing's ring.
      box({-20, -54, -4}, {72, 22, 20}, 6).blend(8),
      cylinder({70, -40, 4}, {70, -92, 4}, 26, 3).blend(6),
      cylinder({-60, 40, -10}, {-60, 84, -10}, 22, 3).blend(6),
      box({30, 52, -8}, {40, 22, 16}, 6).blend(8),
      cylinder({-112, 0, -2}, {-124, 0, -2}, 46, 2).blend(5),
      cylinder({112, 0, -2}, {122, 0, -2}, 34, 2).blend(5),
  };
  for (const double x : {-108.0, -54.0, 0.0, 54.0, 108.0}) {
    for (const double y : {-48.0, 48.0}) out.push_back(upright(x, y, -34, 40, 9, 1).blend(4));
  }
  for (const double x : {-72.0, -36.0, 0.0, 36.0, 72.0}) {
    for (const double y : {-1.0, 1.0}) out.push_back(box({x, 64 * y, -26}, {2.5, 20, 12}, 1).blend(4));
  }
  return out;
}

void addVoids(PartList& parts) {
  Shapes crankcase = {box({0, 0, -52}, {104, 34, 20}, 4), cylinder({-130, 0, -40}, {130, 0, -40}, 17)};
  parts.push_back({"crankcase", kVoid, crankcase});
  Shapes webs;
  for (const double x : {-54.0, 0.0, 54.0}) webs.push_back(box({x, 0, -42}, {5, 36, 14}, 1));
  parts.push_back({"main bearing webs", kMetal, webs});
  parts.push_back({"crankshaft tunnel", kVoid, {cylinder({-130, 0, -46}, {130, 0, -46}, 15)}});
  // The water jacket surrounds the bores and is open to neither; the wall between jacket and bore is a part of its own.
  Shapes jacket, sleeves, bores, liners;
  for (const double x : kBoreX) {
    jacket.push_back(upright(x, 0, -12, 34, 34, 3));
    sleeves.push_back(upright(x, 0, -20, 40, 26, 0));
    liners.push_back(upright(x, 0, -26, kDeck + 0.5, 23, 0));
    bores.push_back(upright(x, 0, -40, kDeck + 6, 20.5, 0));
  }
  parts.push_back({"water jacket", kVoid, jacket});
  parts.push_back({"bore walls", kMetal, sleeves});
  parts.push_back({"cylinder liners", kSteel, liners});
  parts.push_back({"cylinder bores", kVoid, bores});
}

void addChannels(PartList& parts) {
  Shapes water, oil, bolts;
  for (const double x : {-54.0, 0.0, 54.0}) {
    for (const double y : {-26.0, 26.0}) water.push_back(upright(x, y, 26, kDeck + 6, 3.5));
  }
  water.push_back(cylinder({-20, -90, 8}, {-20, -30, 8}, 11));
  water.push_back(cylinder({-60, -90, 0}, {-60, -40, 0}, 7));
  parts.push_back({"cooling channels", kVoid, water});
  oil.push_back(cylinder({-130, 38, -18}, {100, 38, -18}, 4.5));
  oil.push_back(cylinder({70, -100, 4}, {70, -50, 4}, 12));
  for (const double x : {-54.0, 0.0, 54.0}) oil.push_back(cylinder({x, 38, -18}, {x, 8, -44}, 2.5));
  oil.push_back(cylinder({-60, 92, -10}, {-60, 48, -10}, 13));
  parts.push_back({"oil channels", kVoid, oil});
  for (const double x : {-108.0, -54.0, 0.0, 54.0, 108.0}) {
    for (const double y : {-48.0, 48.0}) bolts.push_back(upright(x, y, 0, kDeck + 6, 4.2));
  }
  for (const double x : {-112.0, -70.0, -24.0, 24.0, 70.0, 112.0}) {
    for (const double y : {-78.0, 78.0}) bolts.push_back(upright(x, y, -60, -20, 4));
  }
  for (const glm::dvec2& at : {glm::dvec2(0, 38), glm::dvec2(33, 19), glm::dvec2(33, -19), glm::dvec2(0, -38),
                               glm::dvec2(-33, -19), glm::dvec2(-33, 19)}) {
    bolts.push_back(cylinder({-130, at.x, at.y - 2}, {-114, at.x, at.y - 2}, 3));
  }
  parts.push_back({"bolt holes", kVoid, bolts});
}

void addSteel(PartList& parts) {
  Shapes studs, plugs, dowels;
  for (const double x : {-108.0, 108.0}) {
    for (const double y : {-48.0, 48.0}) studs.push_back(upright(x, y, 4, kDeck + 5, 3.4, 1));
  }
  for (const double x : {-81.0, 27.0}) plugs.push_back(cylinder({x, -74, -4}, {x, -78, -4}, 9, 1));
  plugs.push_back(cylinder({81, 44, 12}, {81, 48, 12}, 12, 1));
  for (const double x : {-96.0, 96.0}) dowels.push_back(upright(x, 54, 36, kDeck + 4, 3));
  parts.push_back({"studs", kSteel, studs});
  parts.push_back({"core plugs", kSteel, plugs});
  parts.push_back({"dowels", kSteel, dowels});
}

}  // namespace

PartList engineParts() {
  PartList parts = {{"casting", kMetal, casting()}};
  addVoids(parts);
  addChannels(parts);
  addSteel(parts);
  return parts;
}

}  // namespace kiln::phantom
