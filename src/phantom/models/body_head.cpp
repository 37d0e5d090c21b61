// The skull and its contents. The vault is solid in the list; later parts hollow it: fluid around the brain, orbits,
// nose, sinuses.
#include <string>

#include "phantom/models/body.h"

namespace kiln::phantom {
namespace {

using Shapes = std::vector<ShapeSpec>;

PartSpec cranium() {
  Shapes shapes = {
      ellipsoid({0, 14, 1762}, {71.5, 91, 84}).shell(1.8),
      ellipsoid({0, -28, 1772}, {56, 49, 56}).shell(1.8).blend(22),
      // The base: behind, below, and in front of the spine.
      ellipsoid({0, 44, 1712}, {54, 50, 36}).shell(1.8).blend(20),
      ellipsoid({0, 0, 1700}, {40, 44, 22}).shell(1.6).blend(14),
  };
  append(shapes, bothSides({
                     // Brow, outer rim of the orbit, mastoid, the ear's bone.
                     cone({8, -74, 1753}, {46, -60, 1751}, 5.5, 5).shell(1.6).blend(8),
                     cone({48, -58, 1750}, {50, -52, 1724}, 4.5, 5).shell(1.5).blend(5),
                     cone({54, 24, 1704}, {51, 20, 1682}, 11, 7).shell(1.4).blend(8),
                     cone({60, 14, 1716}, {24, 6, 1708}, 10, 9).shell(2.4).blend(6),
                 }));
  return {"cranium", kBone, shapes};
}

PartSpec innerTable() {
  return {"inner table of the cranium",
          filledWith(Tissue::kCorticalBone),
          {ellipsoid({0, 15, 1763}, {64.5, 84, 77}), ellipsoid({0, -26, 1776}, {49, 42.5, 47}).blend(20),
           ellipsoid({0, 52, 1716}, {48, 38, 32}).blend(18)}};
}

void addFace(PartList& parts) {
  parts.push_back({"maxilla",
                   kBone,
                   {cone({-16, -62, 1680}, {16, -62, 1680}, 17, 17).shell(1.3),
                    cone({0, -58, 1690}, {0, -40, 1690}, 26, 28).flat({0, 0, 1}, 0.75).shell(1.3).blend(8),
                    cone({15, -70, 1690}, {11, -72, 1738}, 6, 5).shell(1.3).blend(6),
                    cone({-15, -70, 1690}, {-11, -72, 1738}, 6, 5).shell(1.3).blend(6),
                    cone({0, -80, 1684}, {0, -74, 1674}, 4, 7).shell(1.2).blend(5),
                    // Around the sinuses.
                    ellipsoid({28, -51, 1698}, {14, 17, 16.5}).shell(1.3).blend(6),
                    ellipsoid({-28, -51, 1698}, {14, 17, 16.5}).shell(1.3).blend(6)}});
  addPair(parts, "nasal bone", kBone,
          {cone({3, -75, 1754}, {4.5, -89, 1724}, 4, 3.2).shell(1),
           cone({7, -72, 1750}, {9, -78, 1724}, 4, 3.4).shell(1).blend(4)});
  addPair(parts, "zygomatic bone", kBone,
          {cone({30, -64, 1708}, {50, -50, 1712}, 7, 6.5).flat({1, -1.3, 0}, 0.8).shell(1.4),
           cone({50, -50, 1712}, {50, -54, 1740}, 5.5, 4).shell(1.4).blend(5),
           cone({52, -46, 1709}, {63, -14, 1708}, 5, 4).flat({1, 0.3, 0}, 0.6).shell(1.2).blend(4),
           cone({63, -14, 1708}, {62, 8, 1710}, 4, 4.5).flat({1, 0, 0}, 0.6).shell(1.2).blend(3)});
  Shapes mandible = {cone({-13, -76, 1638}, {13, -76, 1638}, 9, 9).flat({0, 1, 0}, 0.7).shell(1.8),
                     ellipsoid({0, -82, 1632}, {13, 6, 8}).shell(1.6).blend(9)};
  append(mandible, bothSides({
                       cone({13, -76, 1638}, {46, -22, 1650}, 10, 10.5).flat({1, 0.6, 0}, 0.55).shell(1.8).blend(5),
                       cone({46, -22, 1650}, {50, -8, 1664}, 10, 10).flat({1, 0.2, 0}, 0.6).shell(1.6).blend(5),
                       cone({50, -8, 1662}, {53, 0, 1696}, 11, 8).flat({1, 0, 0}, 0.45).shell(1.5).blend(5),
                       ellipsoid({53, 3, 1702}, {8, 5, 5}).shell(1.4).blend(4),
                       cone({50, -14, 1672}, {51, -24, 1700}, 7, 3.5).flat({1, 0, 0}, 0.5).shell(1.2).blend(4),
                   }));
  parts.push_back({"mandible", kBone, mandible});
  parts.push_back(
      {"hyoid bone", kBone,
       with(chain(curve({{-18, -4, 1616}, {-12, -26, 1610}, {0, -32, 1609}, {12, -26, 1610}, {18, -4, 1616}}, 2), 2.6,
                  2.6),
            1, 1)});
}

PartList hemispheres() {
  PartList parts;
  // The skull's cavity without the fluid around the brain and the cleft between the hemispheres.
  addPair(parts, "cerebral hemisphere", shellOf(Tissue::kGreyMatter, Tissue::kWhiteMatter),
          {ellipsoid({0, 15, 1765}, {59.5, 79, 70}).shell(3.2),
           ellipsoid({0, -24, 1787}, {44, 38, 33.5}).shell(3.2).blend(18),
           box({-79, 15, 1765}, {80, 110, 110}, 0).carve().shell(3.2).blend(5)});
  for (PartSpec& part : parts) part.folds = {11, 26, 1.0};
  return parts;
}

// A point on the arc of the teeth: x across, y moves back with x².
glm::dvec3 onArc(double x, double front_y, double z) { return {x, front_y + 0.052 * x * x, z}; }

}  // namespace

PartList skull() {
  PartList parts = {cranium(), innerTable()};
  addFace(parts);
  return parts;
}

PartList headContents() {
  PartList parts;
  parts.push_back(
      {"cerebrospinal fluid",
       filledWith(Tissue::kFluid),
       {ellipsoid({0, 15, 1763}, {62.5, 82, 75}), ellipsoid({0, -24, 1786}, {47, 41, 37}).blend(18),
        ellipsoid({0, 50, 1717}, {44, 35, 29}).blend(16), cone({0, 30, 1715}, {0, 36, 1672}, 14, 9).blend(10)}});
  for (PartSpec& side : hemispheres()) parts.push_back(side);
  parts.push_back(
      {"corpus callosum", filledWith(Tissue::kWhiteMatter),
       with(chain(curve({{0, -26, 1758}, {0, -30, 1772}, {0, 0, 1788}, {0, 32, 1782}, {0, 44, 1768}}, 2), 6, 6), 3,
            0)});
  addPair(parts, "lateral ventricle", filledWith(Tissue::kFluid),
          with(chain(curve({{9, -30, 1768}, {9, 0, 1780}, {16, 30, 1774}, {24, 44, 1760}, {32, 26, 1738}}, 2), 6, 4), 3,
               0));
  addPair(parts, "thalamus", filledWith(Tissue::kGreyMatter), {ellipsoid({11, 12, 1758}, {9, 17, 11})});
  addPair(parts, "basal ganglia", filledWith(Tissue::kGreyMatter), {ellipsoid({25, 2, 1758}, {8, 22, 14})});
  parts.push_back({"brain stem",
                   filledWith(Tissue::kWhiteMatter),
                   {cone({0, 14, 1742}, {0, 20, 1716}, 14, 15), cone({0, 22, 1714}, {0, 34, 1680}, 12, 7).blend(8)}});
  parts.push_back(
      {"cerebellum",
       {Tissue::kWhiteMatter, Tissue::kGreyMatter, Tissue::kGreyMatter, 0},
       {ellipsoid({22, 58, 1716}, {26, 26, 22}).shell(7), ellipsoid({-22, 58, 1716}, {26, 26, 22}).shell(7).blend(4),
        ellipsoid({0, 52, 1716}, {10, 22, 20}).shell(7).blend(6)}});
  parts.push_back({"pituitary gland", filledWith(Tissue::kGland), {ellipsoid({0, -8, 1722}, {6, 5, 4})}});
  // A thin wall, open in front; the following parts leave only this wall.
  addPair(parts, "orbit", kBone,
          {ellipsoid({31.5, -54, 1735}, {22, 20, 20}).shell(1.6),
           cone({30, -50, 1735}, {15, -22, 1733}, 16, 6).shell(1.6).blend(6)});
  addPair(parts, "orbital fat", filledWith(Tissue::kFat),
          {ellipsoid({32, -61, 1735}, {19.5, 18, 17.5}), cone({31, -54, 1735}, {15, -22, 1733}, 14, 4).blend(6)});
  addPair(parts, "optic nerve", filledWith(Tissue::kWhiteMatter), {cone({31, -54, 1735}, {12, -16, 1732}, 2.2, 2.2)});
  addPair(parts, "eye muscles", filledWith(Tissue::kMuscle),
          {cone({42, -64, 1735}, {18, -28, 1733}, 2.4, 2), cone({23, -64, 1736}, {15, -28, 1734}, 2.4, 2),
           cone({32, -62, 1746}, {17, -28, 1737}, 2.2, 2), cone({32, -62, 1724}, {17, -28, 1730}, 2.2, 2)});
  addPair(parts, "eye", {Tissue::kEye, Tissue::kMuscle, Tissue::kMuscle, 0}, {ball({32, -65, 1735}, 12.2).shell(1.2)});
  addPair(parts, "lens of the eye", filledWith(Tissue::kLens), {ellipsoid({32, -73, 1735}, {4.6, 2.2, 4.6})});
  parts.push_back({"tongue",
                   filledWith(Tissue::kMuscle),
                   {ellipsoid({0, -48, 1656}, {22, 30, 14}), cone({0, -36, 1652}, {0, -22, 1632}, 18, 16).blend(10)}});
  addPair(parts, "parotid gland", filledWith(Tissue::kGland), {ellipsoid({58, 4, 1676}, {8, 15, 20})});
  addPair(parts, "submandibular gland", filledWith(Tissue::kGland), {ellipsoid({34, -32, 1634}, {9, 15, 10})});
  return parts;
}

PartList teeth() {
  PartList parts;
  for (const bool upper : {true, false}) {
    Shapes shapes;
    for (const double x : {3.6, 10.4, 16.0, 20.6, 24.4, 28.0, 31.0}) {
      const double z = upper ? 1665.5 : 1657.5, front = upper ? -83 : -80.5;
      const double radius = x < 12 ? 3.2 : x < 22 ? 3.5 : 4.3;
      const Shapes tooth =
          bothSides({cone(onArc(x, front, z), onArc(x, front + 1.5, upper ? z + 11 : z - 11), radius, 1.6)});
      append(shapes, tooth);
    }
    parts.push_back({upper ? "upper teeth" : "lower teeth", filledWith(Tissue::kTooth), shapes});
  }
  return parts;
}

}  // namespace kiln::phantom
