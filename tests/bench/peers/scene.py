"""What all renderers draw: volumes, transfer functions and cameras, said once and in the world's lengths (mm)."""

import gzip
import json
import math
from pathlib import Path

import numpy as np

FRAMES = 7
TURN_DEG = 2.0  # from view to view
SHADING = {"ambient": 0.2, "diffuse": 0.8, "specular": 0.0, "power": 16}


class Volume:
    """Cubic voxels of 1 mm and 16 bits, z slowest; `skin` and `bone` are the values in the middle of the two surfaces."""

    spacing = (1.0, 1.0, 1.0)

    def __init__(self, name, voxels, skin, bone, edge_px, up):
        self.name, self.voxels = name, np.ascontiguousarray(voxels, dtype="<u2")
        self.skin, self.bone, self.edge_px, self.up = skin, bone, edge_px, up

    @property
    def dims(self):
        return self.voxels.shape[::-1]

    @property
    def centre(self):
        return np.array([(n - 1) / 2 * s for n, s in zip(self.dims, self.spacing)])

    @property
    def diagonal(self):
        return float(np.linalg.norm([n * s for n, s in zip(self.dims, self.spacing)]))

    def write_nrrd(self, path):
        header = (f"NRRD0004\ntype: uint16\ndimension: 3\nsizes: {' '.join(map(str, self.dims))}\n"
                  f"spacings: {' '.join(map(str, self.spacing))}\nendian: little\nencoding: raw\n\n")
        path.write_bytes(header.encode() + self.voxels.tobytes())

    def functions(self):
        """Name to points (value, opacity per mm, colour)."""
        flesh, ivory = (0.93, 0.74, 0.6), (0.95, 0.91, 0.8)
        skin, bone = self.skin, self.bone
        return {
            "skin": [(skin - 60, 0.0, flesh), (skin + 60, 0.8, flesh)],
            "bone": [(bone - 100, 0.0, ivory), (bone + 100, 0.8, ivory)],
            "both": [(skin - 60, 0.0, flesh), (skin + 60, 0.03, flesh), (bone - 100, 0.03, flesh),
                     (bone + 100, 0.8, ivory)],
        }


def _read_nrrd(path):
    data = path.read_bytes()
    end = data.index(b"\n\n")
    fields = dict(line.split(": ", 1) for line in data[:end].decode().splitlines() if ": " in line)
    raw = gzip.decompress(data[end + 2:]) if fields["encoding"].startswith("gz") else data[end + 2:]
    kind = {"uint16": "<u2", "unsigned short": "<u2", "ushort": "<u2"}.get(fields["type"], "<i2")
    dims = [int(n) for n in fields["sizes"].split()]
    return np.clip(np.frombuffer(raw, kind).reshape(dims[::-1]), 0, 65535).astype("<u2")


def _cubic(voxels, spacing):
    """Slices two voxels apart get another between them: VolPack's normals are of cubic voxels."""
    if spacing[2] == spacing[0]:
        return voxels
    assert spacing[2] == 2 * spacing[0]
    out = np.empty((2 * len(voxels) - 1,) + voxels.shape[1:], voxels.dtype)
    out[::2] = voxels
    out[1::2] = (voxels[:-1].astype(np.uint32) + voxels[1:] + 1) // 2
    return out


def _phantom(n):
    """A head's layers as ellipsoids with soft edges: air, skin, skull, brain."""
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, n, dtype=np.float32)] * 3, indexing="ij")
    r = np.sqrt((x / 0.8) ** 2 + (y / 0.9) ** 2 + (z / 0.9) ** 2) * n * 0.4

    def inside(radius):
        return np.clip(radius * n * 0.4 - r + 0.5, 0, 1)

    return (1000 * inside(1.0) + 900 * inside(0.9) - 850 * inside(0.82) + 0.5).astype("<u2")


def volumes(data, quick):
    """The scans where they are there, else a phantom in their place."""
    scans = [("cthead", "cthead_256x256x113_u16le.nrrd", (1.0, 1.0, 2.0), 500, 1150, 512, (0, 0, -1)),
             ("vhm_head", "vhm_head_512x512x245_i16le.nrrd", (1.0, 1.0, 1.0), 750, 1350, 1024, (0, 0, 1))]
    for name, file, spacing, skin, bone, edge_px, up in scans[:1] if quick else scans:
        path = Path(data) / file
        if path.exists():
            yield Volume(name, _cubic(_read_nrrd(path), spacing), skin, bone, edge_px, up)
        else:
            yield Volume(f"phantom in place of {name}", _phantom(256), 500, 1450, edge_px, (0, 0, 1))


class View:
    """A camera: it looks along -back. `height` is what the picture spans at the volume's centre."""

    def __init__(self, volume, projection, frame):
        angle = math.radians(-70 + (frame - FRAMES // 2) * TURN_DEG)
        self.back = np.array([math.cos(angle), math.sin(angle), 0.15])
        self.back /= np.linalg.norm(self.back)
        self.right = np.cross(volume.up, self.back)
        self.right /= np.linalg.norm(self.right)
        self.up = np.cross(self.back, self.right)
        self.projection, self.fov_deg = projection, 30.0
        self.height = 0.95 * volume.diagonal  # all of it in the picture
        self.distance = self.height / 2 / math.tan(math.radians(self.fov_deg / 2))
        self.target = volume.centre
        self.eye = self.target + self.distance * self.back

    def camera_to_world(self):
        m = np.eye(4)
        m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = self.right, self.up, self.back, self.eye
        return m.tolist()


def views(volume, projection):
    return [View(volume, projection, frame) for frame in range(FRAMES)]


def kiln_job(store, volume, points, cameras, size, shaded, output, more):
    """The job that draws a frame for each of the cameras."""
    projection = cameras[0].projection
    camera = {"projection": projection, "matrices": [v.camera_to_world() for v in cameras]}
    camera.update({"fov": cameras[0].fov_deg} if projection == "perspective" else {"height": cameras[0].height})
    job = {
        "kiln": 1, "volume": str(store), "output": str(output),
        "image": {"width": size, "height": size, "background": [0, 0, 0, 1]}, "camera": camera,
        "transferFunction": {"unit": 1.0, "colorSpace": "linear",
                             "points": [{"value": v, "opacity": o, "color": list(c)} for v, o, c in points]},
        "shading": dict(SHADING, model="phong") if shaded else {"model": "none"},
        "png": {"bits": 16},
    }
    if len(cameras) > 1:
        job["frames"] = f"1-{len(cameras)}"
    job.update(more)
    return json.dumps(job, indent=1)
