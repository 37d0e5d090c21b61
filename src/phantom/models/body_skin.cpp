// The surface of the body, one smooth union: trunk, head, limbs, then the carved shapes. The shell of a shape is the
// fat below its skin; the rest inside is muscle.
#include "phantom/models/body.h"

namespace kiln::phantom {
namespace {

using Shapes = std::vector<ShapeSpec>;

Shapes trunk() {
  Shapes out = {
      // Rib cage, lower chest, belly, pelvis, shoulder girdle, upper chest.
      ellipsoid({0, 8, 1340}, {172, 123, 192}).shell(11),
      ellipsoid({0, 3, 1235}, {165, 116, 132}).shell(14).blend(50),
      ellipsoid({0, 3, 1120}, {162, 119, 172}).shell(20).blend(60),
      ellipsoid({0, 8, 968}, {173, 123, 122}).shell(18).blend(60),
      ellipsoid({0, 30, 1456}, {173, 75, 77}).shell(9).blend(45),
      ellipsoid({0, 0, 1432}, {149, 86, 95}).shell(9).blend(40),
      ellipsoid({0, -46, 1090}, {112, 70, 110}).shell(24).blend(50),
  };
  append(out, bothSides({
                  // Trapezius, latissimus, chest, shoulder blade, buttock, flank, collar bone, point of the shoulder.
                  cone({28, 46, 1594}, {168, 28, 1494}, 31, 29).shell(8).blend(42),
                  cone({136, 38, 1410}, {112, 48, 1180}, 46, 32).shell(10).blend(40),
                  ellipsoid({75, -82, 1412}, {66, 25, 45}).turned({0.5, 0.1, 1}).shell(10).blend(42),
                  ellipsoid({98, 84, 1420}, {60, 32, 80}).shell(9).blend(40),
                  ellipsoid({74, 78, 928}, {80, 68, 84}).shell(24).blend(28),
                  ellipsoid({122, 8, 1055}, {46, 74, 66}).shell(18).blend(45),
                  cone({18, -47, 1494}, {66, -46, 1499}, 12.5, 12.5).shell(4).blend(22),
                  cone({66, -46, 1499}, {120, -10, 1504}, 12.5, 13).shell(4).blend(22),
                  cone({120, -10, 1504}, {186, 20, 1502}, 13, 17).shell(4).blend(26),
              }));
  append(out, {
                  // The furrows of the spine, of the breast bone and down the belly; the navel.
                  cone({0, 155, 1440}, {0, 146, 1080}, 15, 15).carve().shell(6).blend(30),
                  cone({0, -131, 1428}, {0, -133, 1330}, 9, 9).carve().shell(6).blend(26),
                  cone({0, -140, 1300}, {0, -137, 1130}, 8, 8).carve().shell(8).blend(20),
                  ball({0, -128, 1112}, 7).carve().shell(10).blend(8),
              });
  return out;
}

Shapes neckAndHead() {
  Shapes out = {
      cone({0, 28, 1505}, {0, 14, 1650}, 66, 58).flat({0, 1, 0}, 1.02).shell(6).blend(36),
      // Vault of the skull, forehead, face, back of the head.
      ellipsoid({0, 14, 1762}, {77, 97, 90}).shell(4).blend(22),
      ellipsoid({0, -30, 1772}, {62, 54, 62}).shell(4).blend(24),
      ellipsoid({0, -34, 1700}, {61, 58, 66}).shell(5).blend(26),
      ellipsoid({0, 48, 1715}, {58, 55, 55}).shell(5).blend(26),
      // Chin and the floor of the mouth.
      ellipsoid({0, -68, 1640}, {25, 23, 21}).shell(4).blend(20),
      cone({0, -52, 1645}, {0, -30, 1600}, 28, 34).shell(5).blend(26),
      // Larynx.
      ellipsoid({0, -44, 1578}, {13, 12, 20}).shell(4).blend(16),
  };
  append(out, bothSides({
                  // Jaw, cheek bone, cheek, sternomastoid.
                  cone({50, 0, 1672}, {18, -66, 1638}, 19, 16).shell(4).blend(24),
                  cone({57, -10, 1714}, {42, -62, 1711}, 14, 15).shell(4).blend(20),
                  ellipsoid({34, -56, 1676}, {20, 26, 24}).shell(7).blend(20),
                  cone({20, -36, 1504}, {55, 30, 1662}, 12, 13).shell(5).blend(22),
                  // Eye sockets, carved under the brow.
                  ellipsoid({34, -93, 1736}, {20, 18, 14}).carve().shell(3).blend(15),
              }));
  append(out, bothSides({
                  cone({9, -80, 1753}, {46, -68, 1756}, 7, 6).shell(3).blend(14),
                  // Lids over the eyeball, and the line between the lids.
                  ball({32, -66.5, 1735}, 14.8).shell(2).blend(3),
                  cone({20.5, -77, 1733.5}, {32, -82, 1731}, 1, 1.4).carve().shell(1).blend(2.5),
                  cone({32, -82, 1731}, {44, -76, 1733.5}, 1.4, 1).carve().shell(1).blend(2.5),
                  // Behind the ear.
                  ball({55, 24, 1694}, 16).shell(3).blend(20),
              }));
  // Nose: bridge, tip, wings, septum; nostrils that end in the vestibule.
  append(out,
         {cone({0, -80, 1750}, {0, -108, 1708}, 8.5, 9.5).shell(3).blend(10),
          ball({0, -111, 1701}, 11).shell(3).blend(8), cone({0, -104, 1694}, {0, -88, 1686}, 6, 8).shell(3).blend(6)});
  append(out, bothSides({
                  ellipsoid({12, -99, 1696}, {7.5, 11, 8.5}).shell(3).blend(6),
                  cone({6.5, -104, 1686}, {5.5, -100, 1697}, 3.2, 2.6).carve().shell(1).blend(2),
                  // Folds from the nose to the mouth's corners.
                  cone({19, -99, 1690}, {31, -88, 1664}, 3, 3).carve().shell(3).blend(9),
              }));
  // Mouth: the lips' roll, the slit between, the dents above and below.
  append(out, {
                  ellipsoid({0, -70, 1664}, {30, 23, 24}).shell(4).blend(12),
                  cone({0, -92.5, 1668}, {22, -84, 1663.5}, 5.6, 3).shell(2).blend(5),
                  cone({0, -92.5, 1668}, {-22, -84, 1663.5}, 5.6, 3).shell(2).blend(5),
                  cone({-13, -87.5, 1656.5}, {13, -87.5, 1656.5}, 6.4, 6.4).shell(2).blend(5),
                  cone({0, -98, 1681}, {0, -97, 1673}, 2.2, 2.6).carve().shell(2).blend(4),
                  ellipsoid({0, -97, 1648}, {15, 7, 4.5}).carve().shell(3).blend(7),
                  cone({0, -98, 1662.6}, {27, -83, 1661.5}, 1.4, 1).carve().shell(1).blend(2.5),
                  cone({0, -98, 1662.6}, {-27, -83, 1661.5}, 1.4, 1).carve().shell(1).blend(2.5),
              });
  return out;
}

// The left ear: a plate, its rolled rim, the lobe, and the hollow in front of the canal.
Shapes ear() {
  const std::vector<glm::dvec3> rim =
      curve({{76, -2, 1736}, {83, 4, 1758}, {88, 20, 1765}, {91, 33, 1750}, {87, 30, 1727}, {80, 14, 1706}}, 3);
  Shapes out = {ellipsoid({82, 16, 1737}, {5, 17, 28}).turned({0.12, 0.18, 1}, {0.35, 1, 0}).shell(2).blend(6)};
  append(out, with(chain(rim, 3.4, 4.2), 3, 1.5));
  append(out, {ellipsoid({79, 8, 1704}, {4.5, 8, 10}).shell(2).blend(5),
               ellipsoid({88, 12, 1733}, {8, 9, 13}).carve().shell(1).blend(5),
               cone({76, 2, 1732}, {82, 2, 1730}, 4, 3.5).shell(1.5).blend(4)});
  return out;
}

Shapes arm() {
  return {
      ellipsoid({206, 18, 1452}, {47, 54, 72}).turned({0.32, 0, 1}).shell(8).blend(36),
      cone({206, 18, 1440}, {238, 24, 1195}, 47, 36).shell(8).blend(26),
      // Biceps, triceps (long and lateral heads).
      ellipsoid({221, -12, 1325}, {33, 33, 92}).turned({-0.11, -0.02, 1}).shell(7).blend(18),
      ellipsoid({222, 50, 1355}, {36, 33, 98}).turned({-0.12, 0.03, 1}).shell(8).blend(18),
      ellipsoid({236, 34, 1390}, {23, 32, 62}).turned({-0.1, 0, 1}).shell(7).blend(18),
      // Elbow; the bellies of the forearm; towards the wrist.
      ellipsoid({241, 30, 1180}, {36, 36, 38}).shell(6).blend(20),
      ellipsoid({249, 6, 1110}, {39, 47, 96}).turned({-0.09, 0.14, 1}).shell(6).blend(18),
      ellipsoid({243, 28, 1120}, {34, 36, 84}).turned({-0.08, 0.16, 1}).shell(6).blend(18),
      cone({252, 6, 1080}, {262, -9, 935}, 37, 27).flat({1, 0.1, 0}, 0.84).shell(5).blend(18),
      cone({262, -9, 945}, {264, -11, 915}, 29, 29).flat({1, 0, 0}, 0.68).shell(4).blend(14),
  };
}

Shapes leg() {
  return {
      cone({94, 14, 915}, {92, 4, 560}, 96, 62).shell(13).blend(34),
      // Front of the thigh: rectus, lateral and medial bellies above the knee; behind; inside; hip.
      ellipsoid({100, -36, 740}, {54, 48, 150}).turned({0.03, -0.05, 1}).shell(10).blend(30),
      ellipsoid({128, -8, 700}, {38, 50, 140}).turned({0.1, 0, 1}).shell(10).blend(26),
      ellipsoid({64, -24, 610}, {29, 35, 58}).turned({-0.1, 0, 1}).shell(8).blend(22),
      ellipsoid({122, -24, 620}, {24, 35, 64}).turned({0.1, 0, 1}).shell(8).blend(22),
      ellipsoid({90, 54, 730}, {57, 46, 150}).shell(13).blend(28),
      ellipsoid({60, 12, 835}, {46, 64, 100}).turned({-0.06, 0, 1}).shell(16).blend(20),
      ellipsoid({140, 14, 915}, {46, 68, 100}).shell(18).blend(36),
      // Knee, knee cap, tendon, hollow behind.
      ellipsoid({91, 2, 522}, {55, 56, 60}).shell(7).blend(26),
      ellipsoid({92, -46, 528}, {21, 13, 24}).shell(5).blend(14),
      cone({91, -44, 500}, {90, -34, 465}, 11, 15).shell(5).blend(16),
      // Calf: two bellies and the flat muscle below them, the shin.
      cone({90, 12, 500}, {89, 35, 130}, 52, 34).shell(7).blend(26),
      ellipsoid({70, 48, 398}, {34, 41, 98}).turned({0.03, 0.04, 1}).shell(8).blend(22),
      ellipsoid({109, 48, 408}, {32, 39, 94}).turned({-0.03, 0.04, 1}).shell(8).blend(22),
      ellipsoid({103, 2, 385}, {27, 30, 112}).turned({-0.03, -0.08, 1}).shell(6).blend(20),
      // Heel tendon, ankles.
      cone({89, 44, 290}, {90, 72, 88}, 20, 15).shell(4).blend(26),
      ball({64, 33, 112}, 14).shell(4).blend(14),
      ball({115, 42, 102}, 13).shell(4).blend(14),
  };
}

}  // namespace

PartSpec bodySurface() {
  Shapes shapes = trunk();
  append(shapes, neckAndHead());
  append(shapes, bothSides(ear()));
  append(shapes, bothSides(arm()));
  append(shapes, bothSides(leg()));
  append(shapes, bothSides(handAndFootFlesh()));
  append(shapes, {cone({0, 175, 950}, {0, 120, 850}, 10, 12).carve().shell(14).blend(22),
                  ellipsoid({0, -74, 884}, {26, 24, 34}).shell(9).blend(24),
                  // The ground.
                  box({0, -30, 0}, {200, 160, 22}, 0).carve().shell(4).blend(4)});
  return {"body surface", {Tissue::kMuscle, Tissue::kFat, Tissue::kSkin, 2}, shapes};
}

}  // namespace kiln::phantom
