/* VolPack's shear-warp over a list of orthographic views: volpack_frames VOXELS.u8 OUT.rgb < SCENE. SCENE is numbers:
   nx ny nz, edge of the picture in pixels, its height in voxels, ambient, diffuse, number of views; 256 times the opacity
   of a voxel and its colour; for each view the directions right, up and towards the eye. The program writes the middle
   view's picture, 8-bit RGB, and prints the seconds of making normals, of classifying, and of each view. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <volpack.h>

typedef struct {
  short normal;
  unsigned char scalar, gradient;
} Voxel;

enum { kNormal, kScalar, kGradient, kChannels = 3, kMaterials = 3 };

static void die(const char *what) {
  fprintf(stderr, "volpack_frames: %s\n", what);
  exit(1);
}

static void require(vpContext *context, vpResult result) {
  if (result != VP_OK) die(vpGetErrorString(vpGetError(context)));
}

static double number(void) {
  double out;
  if (scanf("%lf", &out) != 1) die("the scene ends too early");
  return out;
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void *room(size_t bytes) {
  void *out = calloc(bytes, 1);
  if (out == NULL) die("no memory");
  return out;
}

static unsigned char *readVoxels(const char *path, size_t count) {
  unsigned char *out = room(count);
  FILE *file = fopen(path, "rb");
  if (file == NULL || fread(out, 1, count, file) != count) die("the voxels cannot be read");
  fclose(file);
  return out;
}

static void describeVoxels(vpContext *context, int nx, int ny, int nz) {
  Voxel *dummy = NULL;
  require(context, vpSetVolumeSize(context, nx, ny, nz));
  require(context, vpSetVoxelSize(context, sizeof(Voxel), 3, 2, 1));
  require(context, vpSetVoxelField(context, kNormal, sizeof(short), vpFieldOffset(dummy, normal), VP_NORM_MAX));
  require(context, vpSetVoxelField(context, kScalar, 1, vpFieldOffset(dummy, scalar), 255));
  require(context, vpSetVoxelField(context, kGradient, 1, vpFieldOffset(dummy, gradient), VP_GRAD_MAX));
}

/* A material for each of red, green and blue: a voxel's colour is how much it has of each. */
static void describeMaterials(vpContext *context, double ambient, double diffuse) {
  for (int m = 0; m < kMaterials; ++m) {
    const double r = m == 0, g = m == 1, b = m == 2;
    const int material = VP_MATERIAL0 + m;
    require(context, vpSetMaterial(context, material, VP_AMBIENT, VP_BOTH_SIDES, ambient * r, ambient * g, ambient * b));
    require(context, vpSetMaterial(context, material, VP_DIFFUSE, VP_BOTH_SIDES, diffuse * r, diffuse * g, diffuse * b));
    require(context, vpSetMaterial(context, material, VP_SPECULAR, VP_BOTH_SIDES, 0, 0, 0));
    require(context, vpSetMaterial(context, material, VP_SHINYNESS, VP_BOTH_SIDES, 1, 0, 0));
  }
  require(context, vpSetLight(context, VP_LIGHT0, VP_COLOR, 1, 1, 1));
  require(context, vpEnable(context, VP_LIGHT_BOTH_SIDES, 1));
}

/* Voxels are cubes here: VolPack's middle of n voxels lies half a voxel before the middle of their cubes. */
static void look(vpContext *context, double height, double voxel) {
  vpMatrix4 view;
  vpIdentity4(view);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      view[row][column] = number();
      view[row][3] += voxel / 2 * view[row][column];
    }
  }
  /* Depth grows away from the eye. */
  for (int column = 0; column < 4; ++column) view[2][column] = -view[2][column];
  require(context, vpCurrentMatrix(context, VP_MODEL));
  require(context, vpIdentityMatrix(context));
  require(context, vpSetLight(context, VP_LIGHT0, VP_DIRECTION, view[2][0], view[2][1], view[2][2]));
  require(context, vpCurrentMatrix(context, VP_VIEW));
  require(context, vpSetMatrix(context, view));
  require(context, vpCurrentMatrix(context, VP_PROJECT));
  require(context, vpIdentityMatrix(context));
  require(context, vpWindow(context, VP_PARALLEL, -height / 2, height / 2, -height / 2, height / 2, -1, 1));
}

int main(int argc, char **argv) {
  if (argc != 3) die("usage: volpack_frames VOXELS.u8 OUT.rgb < SCENE");
  const int nx = (int)number(), ny = (int)number(), nz = (int)number();
  const int edge = (int)number();
  const double height_voxels = number(), ambient = number(), diffuse = number();
  const int views = (int)number();
  const size_t count = (size_t)nx * (size_t)ny * (size_t)nz;
  float opacities[256], *weights = room(256 * kMaterials * sizeof(float));
  for (int i = 0; i < 256; ++i) {
    opacities[i] = (float)number();
    for (int m = 0; m < kMaterials; ++m) weights[i * kMaterials + m] = (float)number();
  }
  unsigned char *scalars = readVoxels(argv[1], count);
  vpContext *context = vpCreateContext();
  describeVoxels(context, nx, ny, nz);
  Voxel *voxels = room(count * sizeof(Voxel));
  require(context, vpSetRawVoxels(context, voxels, (int)(count * sizeof(Voxel)), sizeof(Voxel), nx * (int)sizeof(Voxel),
                                  nx * ny * (int)sizeof(Voxel)));
  const double begin = seconds();
  require(context, vpVolumeNormals(context, scalars, (int)count, kScalar, kGradient, kNormal));
  const double normals = seconds();
  require(context, vpSetClassifierTable(context, 0, kScalar, opacities, sizeof opacities));
  require(context, vpSetd(context, VP_MIN_VOXEL_OPACITY, 0.004));
  require(context, vpClassifyVolume(context));
  const double classified = seconds();
  printf("normals %.6f\nclassify %.6f\n", normals - begin, classified - normals);

  const size_t table_bytes = (VP_NORM_MAX + 1) * kMaterials * kChannels * sizeof(float);
  require(context, vpSetLookupShader(context, kChannels, kMaterials, kNormal, room(table_bytes), (int)table_bytes, kScalar,
                                     weights, 256 * kMaterials * (int)sizeof(float)));
  describeMaterials(context, ambient, diffuse);
  require(context, vpSetd(context, VP_MAX_RAY_OPACITY, 0.998));
  unsigned char *image = room((size_t)edge * (size_t)edge * 3);
  require(context, vpSetImage(context, image, edge, edge, edge * 3, VP_RGB));
  /* The volume's longest edge is of length 1. */
  int longest = nx > ny ? nx : ny;
  longest = longest > nz ? longest : nz;
  for (int i = 0; i < views; ++i) {
    look(context, height_voxels / longest, 1.0 / longest);
    const double frame = seconds();
    require(context, vpShadeTable(context));
    require(context, vpRenderClassifiedVolume(context));
    printf("frame %.6f\n", seconds() - frame);
    if (i != views / 2) continue;
    FILE *file = fopen(argv[2], "wb");
    if (file == NULL || fwrite(image, 3, (size_t)edge * (size_t)edge, file) != (size_t)edge * (size_t)edge)
      die("the picture cannot be written");
    fclose(file);
  }
  vpDestroyContext(context);
  return 0;
}
