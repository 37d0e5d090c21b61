"""Arrays as volumes. Known because an array holds the voxels of a file whose pictures and stores are known, or because
the array counts what is read of it."""

import os
import threading

import numpy
import pytest

import kiln
from conftest import run_tool

SIZE = {"size": (64, 48), "tf": "grayscale"}
SPACING = (2.0, 1.0, 0.5)


def ramp(dtype, shape=(20, 30, 40)):
    """Values that differ along each axis, and fit all types."""
    z, y, x = numpy.indices(shape)
    return ((3 * z + 2 * y + x) % 120).astype(dtype)


def picture(volume, **words):
    return numpy.asarray(volume.render(**{**SIZE, **words}))


def same_voxels(volume, expected):
    return volume.shape == expected.shape and (volume[...] == expected).all()


@pytest.mark.parametrize(
    "dtype, stored",
    [(name, name) for name in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64")]
    + [("int64", "int32"), ("uint64", "uint32"), ("float16", "float32"), ("bool", "uint8")]
    + [(">u2", "uint16"), (">i4", "int32"), (">f4", "float32"), (">f8", "float64")],
)
def test_types(dtype, stored):
    array = ramp(dtype)
    s = kiln.open(array, spacing=SPACING)
    assert s.dtype == stored and same_voxels(s, array.astype(stored))
    assert s.spacing == SPACING and s.shape == array.shape
    native = kiln.open(array.astype(stored), spacing=SPACING)
    assert (picture(s) == picture(native)).all()
    store = kiln.convert(array, "a.kiln", spacing=SPACING)
    assert same_voxels(store, array.astype(stored)) and store.spacing == SPACING
    assert (picture(s) == picture(store)).all()


def test_numbers_that_do_not_fit_are_refused():
    array = ramp("int64")
    array[3, 4, 5] = 1 << 40
    with pytest.raises(kiln.Error, match="1099511627776") as failure:
        kiln.convert(array, "a.kiln")
    assert failure.value.code == "format"
    for dtype in ("complex64", "U3"):
        with pytest.raises(kiln.Error) as failure:
            kiln.open(numpy.zeros((4, 4, 4), dtype))
        assert failure.value.code == "unsupported"


@pytest.mark.parametrize(
    "view",
    [
        lambda a: numpy.asfortranarray(a),
        lambda a: a[::-1, ::-1, ::-1],
        lambda a: a[::2, 1:-1:3, 5:],
        lambda a: numpy.ascontiguousarray(a.transpose(1, 2, 0)).transpose(2, 0, 1),
        lambda a: numpy.broadcast_to(a[0], a.shape),
        lambda a: numpy.lib.stride_tricks.sliding_window_view(a[0], (3, 4))[:, 0],
    ],
    ids=["fortran", "reversed", "steps", "transposed", "broadcast", "overlapping"],
)
@pytest.mark.parametrize("dtype", ["uint16", ">u2"])
def test_orders_and_strides(view, dtype):
    array = view(ramp(dtype))
    s = kiln.open(array)
    plain = kiln.open(numpy.array(array, dtype="uint16", order="C"))
    assert same_voxels(s, numpy.asarray(array)) and (picture(s) == picture(plain)).all()


def test_axes():
    array = ramp("uint8")
    plain = kiln.open(array, spacing=SPACING)
    for axes in ("xyz", "yzx", "xzy"):
        order = ["zyx".index(axis) for axis in axes]
        other = kiln.open(array.transpose(order), axes=axes, spacing=[SPACING[i] for i in order])
        assert same_voxels(other, array) and other.spacing == SPACING
    several = numpy.stack([array, array + 1, array + 2])[:, None]
    for dtype in ("uint8", "int64"):
        assert same_voxels(kiln.open(several.astype(dtype), axes="ctzyx", channel=1), array + 1)
    assert kiln.open(array[0]).shape == (1, 30, 40)

    class Named(numpy.ndarray):  # as xarray's
        dims = ("y", "z", "x")

    assert same_voxels(kiln.open(array.transpose(1, 0, 2).view(Named)), array)
    affine = numpy.diag([0.5, 1, 2, 1]) + numpy.eye(4, k=3) * 7
    assert (kiln.open(array, affine=affine).affine == affine).all()
    assert plain.affine[0, 0] == 0.5 and plain.affine[2, 2] == 2
    for words in ({"axes": "zy"}, {"axes": "zzx"}, {"spacing": (1, 1)}, {"spacing": (1, 1, 1), "affine": affine}, {"affine": [[1]]}, {"affine": affine.T}, {"frame": "LAS"}):
        with pytest.raises(ValueError, match=next(iter(words)).split("_")[0]):
            kiln.open(array, **words)


def test_array_equals_its_conversion_by_the_program():
    array = ramp("uint16", (70, 60, 50))
    numpy.save("a.npy", array)
    run_tool("convert", "a.npy", "tool.kiln", "--brick-size", 32, "--spacing", "0.5,1,2", cwd=".")
    run_tool("render", "tool.kiln", "-o", "tool.exr", "--exr-type", "float", "--size", "64x48", "--tf", "viridis", cwd=".")
    for volume in (
        kiln.open(array, spacing=SPACING, brick_size=32),
        kiln.convert(array, "python.kiln", spacing=SPACING, brick_size=32),
        kiln.convert("a.npy", "file.kiln", spacing=SPACING, brick_size=32),
    ):
        image = volume.render(size=(64, 48), tf="viridis")
        image.save("python.exr", exr_type="float")
        tool = kiln.open("tool.kiln").render(size=(64, 48), tf="viridis")
        assert (numpy.asarray(image) == numpy.asarray(tool)).all()
        assert volume.levels == kiln.open("tool.kiln").levels
        assert (volume.read(1) == kiln.open("tool.kiln").read(1)).all()


def test_labels_of_32_bits_are_counted_up_to_65534():
    """Known: the manual says so."""
    for dtype, values, counted in [
        ("i4", (0, 65534), True),
        ("i4", (0, 65535), False),
        ("i4", (-1, 3), False),
        ("i2", (-1, 3), True),
    ]:
        array = numpy.full((4, 4, 4), values[0], dtype)
        array[0, 0, 0] = values[1]
        assert kiln.open(array, labels=True).labels == ({values[0]: 63, values[1]: 1} if counted else None)


def test_labels():
    array = ramp("int64") // 40
    s = kiln.open(array, labels=True)
    assert s.labels == {value: int((array == value).sum()) for value in range(3)}
    assert kiln.convert(array, "a.kiln", labels=True).labels == s.labels


class Counting:
    """An array like dask's: chunks, a shape, a dtype, and slices that are made when they are read."""

    def __init__(self, array, chunks):
        self.array, self.shape, self.dtype = array, array.shape, array.dtype
        self.chunks = tuple(
            tuple(min(edge, length - at) for at in range(0, length, edge)) for edge, length in zip(chunks, array.shape)
        )
        self.boxes, self.lock, self.most_bytes = [], threading.Lock(), 0

    def __getitem__(self, key):
        piece = numpy.array(self.array[key])
        with self.lock:
            self.boxes.append(tuple((one.start, one.stop) for one in key))
            self.most_bytes = max(self.most_bytes, piece.nbytes)
        return piece

    def times_read(self):
        """How often each voxel was read."""
        counts = numpy.zeros(self.shape, dtype=int)
        for box in self.boxes:
            counts[tuple(slice(*edges) for edges in box)] += 1
        return counts


@pytest.mark.parametrize("chunks", [(32, 64, 64), (20, 30, 70), (7, 100, 120)])
def test_each_box_is_read_once(chunks):
    array = ramp("uint16", (80, 100, 120))
    counting = Counting(array, chunks)
    s = kiln.convert(counting, "a.kiln", brick_size=32)
    assert same_voxels(s, array)
    assert (counting.times_read() == 1).all()
    assert s.report["decodings"] == 1
    for low, high in (edges for box in counting.boxes for edges in [box[0]]):
        assert low % chunks[0] == 0, "a chunk was cut"


def test_little_memory_is_kept_to():
    array = ramp("uint16", (128, 128, 128))
    counting = Counting(array, (64, 64, 64))
    s = kiln.convert(counting, "a.kiln", brick_size=32, memory="24M", threads=1)
    assert same_voxels(s, array)
    assert s.report["buffer_bytes"] <= 24 << 20 and counting.most_bytes <= 64**3 * 2
    with pytest.raises(kiln.Error) as failure:
        kiln.convert(counting, "b.kiln", memory="1M")
    assert failure.value.code == "budget"


def test_an_index_larger_than_memory_is_refused_before_it_is_made():
    """Known: the index of 1.4e11 bricks fits no machine."""
    endless = numpy.broadcast_to(numpy.zeros(1, "u1"), (1 << 10, 1 << 20, 1 << 21))
    with pytest.raises(kiln.Error, match="index take") as failure:
        kiln.open(endless, memory="64M", brick_size=16)
    assert failure.value.code == "budget"


def test_drawing_slices_on_demand():
    array = ramp("uint16", (80, 100, 120))
    counting = Counting(array, (40, 50, 60))
    s = kiln.open(counting, brick_size=32)
    assert (counting.times_read() >= 1).all(), "coarser levels need all voxels"
    assert (picture(s) == picture(kiln.open(array, brick_size=32))).all()


def test_exception_of_an_array_is_the_callers():
    class Failing(Counting):
        def __getitem__(self, key):
            if key[0].start > 0:
                raise RuntimeError("the tape is gone")
            return super().__getitem__(key)

    failing = Failing(ramp("uint16", (80, 40, 40)), (16, 40, 40))
    with pytest.raises(RuntimeError, match="the tape is gone"):
        kiln.convert(failing, "a.kiln", brick_size=16)
    with pytest.raises(RuntimeError, match="the tape is gone"):
        kiln.open(failing)

    class Short(Counting):
        def __getitem__(self, key):
            return super().__getitem__(key)[:1]

    with pytest.raises(ValueError, match="instead of"):
        kiln.convert(Short(ramp("uint16"), (10, 10, 10)), "short.kiln")


def test_exception_while_drawing_is_the_cause():
    class Failing(Counting):
        broken = False

        def __getitem__(self, key):
            if self.broken:
                raise RuntimeError("the tape is gone")
            return super().__getitem__(key)

    # Slices of more than the 64 MiB that are kept.
    failing = Failing(numpy.broadcast_to(ramp("uint16", (1, 300, 300)), (400, 300, 300)), (100, 100, 100))
    s = kiln.open(failing)
    failing.broken = True
    for call in (lambda: picture(s), lambda: s[...], lambda: list(s.frames(turntable=2, **SIZE))):
        with pytest.raises(kiln.Error, match="the array raised RuntimeError: the tape is gone$") as failure:
            call()
        assert isinstance(failure.value.__cause__, RuntimeError) and failure.value.code == "io"
        assert failure.value.__cause__.__traceback__ is not None
    failing.broken = False
    assert picture(s).any()


def test_masked_voxels_are_refused():
    plain = ramp("uint16", (20, 30, 40))
    mask = numpy.zeros(plain.shape, bool)
    whole = numpy.ma.MaskedArray(plain, mask)
    assert same_voxels(kiln.open(whole), plain)
    assert same_voxels(kiln.open(numpy.ma.MaskedArray(plain)), plain)
    mask[3, 4, 5:7] = True
    masked = numpy.ma.MaskedArray(plain, mask, fill_value=7)
    for dtype in ("uint16", "int64"):
        for use in (kiln.open, lambda array: kiln.convert(array, "a.kiln")):
            with pytest.raises(kiln.Error, match=r"^array: .+ \(found 2 masked\); array.filled") as failure:
                use(masked.astype(dtype))
            assert failure.value.code == "usage"
    assert kiln.open(masked.filled())[3, 4, 5] == 7

    class Lazy(Counting):
        """As netCDF4: slices of a variable are masked."""

        def __getitem__(self, key):
            return numpy.ma.MaskedArray(super().__getitem__(key), mask[key])

    with pytest.raises(kiln.Error, match=r"found 2 masked"):
        kiln.convert(Lazy(plain, (20, 30, 40)), "a.kiln")


def test_interrupted_conversion_is_resumed():
    array = ramp("uint16", (320, 64, 64))
    plain = Counting(array, (16, 64, 64))
    kiln.convert(plain, "whole.kiln", brick_size=16)

    class Breaking(Counting):
        def __getitem__(self, key):
            if len(self.boxes) == 3:
                raise OSError("a cable")
            return super().__getitem__(key)

    with pytest.raises(OSError):
        kiln.convert(Breaking(array, (16, 64, 64)), "a.kiln", brick_size=16, threads=1, identity="ramp")
    again = Counting(array, (16, 64, 64))
    with pytest.raises(kiln.Error, match="identity"):
        kiln.convert(again, "a.kiln", brick_size=16, resume=True)
    s = kiln.convert(again, "a.kiln", brick_size=16, resume=True, identity="ramp")
    assert same_voxels(s, array)
    assert len(again.boxes) < len(plain.boxes)
    with pytest.raises(kiln.Error) as failure:
        kiln.convert(Counting(array, (16, 64, 64)), "a.kiln", identity="other")
    assert failure.value.code == "exists"


def test_memmap_h5py_and_zarr():
    import h5py
    import zarr

    array = ramp("int16", (40, 50, 60))
    mapped = numpy.memmap("a.raw", dtype="int16", mode="w+", shape=array.shape)
    mapped[...] = array
    mapped.flush()
    with h5py.File("a.h5", "w") as file:
        file.create_dataset("x", data=array, chunks=(16, 16, 16))
    zarr.save_array("a.zarr", array, chunks=(16, 25, 60))
    with h5py.File("a.h5", "r") as file:
        for name, source in (("m", mapped), ("h", file["x"]), ("z", zarr.open("a.zarr", mode="r"))):
            out = name + ".kiln"
            assert same_voxels(kiln.convert(source, out), array)
            assert same_voxels(kiln.convert(source, out, resume=True), array)


def test_resume_tells_voxels_of_one_file_apart():
    """Each pair has equal files, shapes and types. A resumed conversion of the second must not keep the first's bricks."""
    import h5py

    cube = ramp("int16", (20, 20, 20))
    mapped = numpy.memmap("a.raw", dtype="int16", mode="w+", shape=(4, 20, 20, 20))
    mapped[...] = numpy.stack([cube, cube + 1, cube[::-1], cube.transpose(2, 1, 0)])
    mapped.flush()
    same = numpy.memmap("a.raw", dtype="int16", mode="r", offset=16000, shape=cube.shape)
    with h5py.File("a.h5", "w") as file:
        file.create_dataset("x", data=mapped)
    with h5py.File("a.h5", "r") as file:
        sources = {"mapped": mapped, "h5": file["x"]}
        pairs = {"place": ((mapped[0], {}), (mapped[1], {})), "order": ((mapped[0], {}), (mapped[0].view(">i2"), {}))}
        for name, source in sources.items():
            pairs[name + " time"] = tuple((source, {"axes": "tzyx", "time": i}) for i in (0, 1))
            pairs[name + " channel"] = tuple((source, {"axes": "czyx", "channel": i}) for i in (2, 3))
            pairs[name + " axes"] = tuple((source, {"axes": axes, "time": 1}) for axes in ("tzyx", "txyz"))
        pairs["identity"] = tuple((cube, {"axes": axes, "identity": "cube"}) for axes in ("zyx", "xyz"))
        for name, ((first, words), (second, other)) in pairs.items():
            kiln.convert(first, name, brick_size=16, **words)
            with pytest.raises(kiln.Error) as failure:
                kiln.convert(second, name, brick_size=16, resume=True, **other)
            assert failure.value.code in ("exists", "replaced"), name
            assert kiln.convert(first, name, brick_size=16, resume=True, **words).shape == cube.shape
    assert same_voxels(kiln.convert(same, "same"), cube + 1)


def test_words_without_effect_are_refused():
    array = ramp("uint8", (8, 8, 8))
    numpy.save("a.npy", array)
    of_arrays = {"axes": "xyz", "frame": "RAS"}
    refused = [(kiln.open, array, word, value) for word, value in {"channel": 1, "time": 0, "store": "stores"}.items()]
    refused += [(kiln.convert, array, word, value) for word, value in {"channel": 0, "time": 2, "levels": -1}.items()]
    refused += [(kiln.open, "a.npy", word, value) for word, value in {**of_arrays, "brick_size": 128}.items()]
    refused += [(kiln.convert, "a.npy", word, value) for word, value in {**of_arrays, "identity": "a", "levels": -2}.items()]
    refused += [
        (call, "a.npy", word, value)
        for call in (kiln.open, kiln.convert)
        for word in ("allow_irregular", "luminance")
        for value in ("yes", "", 1)
    ]
    refused += [(kiln.open, "a.npy", "store", value) for value in (3, ["stores"], False)]
    refused += [(kiln.render, job, "store", 3) for job in ({"volume": "a.npy"}, "a.json")]
    refused += [(kiln.view, array, "port", value) for value in (70000, 65536, -1, 1.5)]
    refused += [(call, array, word, 3) for call in (kiln.open, kiln.convert) for word in ("dims", "bogus")]
    refused += [(kiln.convert, array, word, 2.5) for word in ("levels", "threads", "brick_size")]
    refused += [(kiln.convert, array, "threads", -1), (kiln.open, array, "brick_size", 16.5)]
    for call, source, word, value in refused:
        with pytest.raises(kiln.Error, match=rf"^{word}: .+ \(found .+\); .+") as failure:
            call(source, *(["out.kiln"] if call is kiln.convert else []), **{word: value})
        assert failure.value.code == "usage" and failure.value.path is None
    assert sorted(os.listdir()) == ["a.npy"]
    volume = kiln.convert("a.npy", "a.kiln", allow_irregular=False, luminance=False, levels=1, spacing=SPACING)
    assert same_voxels(volume, array) and len(volume.levels) == 1 and volume.spacing == SPACING
    assert kiln.open("a.npy", unit="um").unit == "um"


def test_values_that_are_no_names_are_refused_with_a_remedy():
    volume = kiln.open(ramp("uint8", (8, 8, 8)))
    source = "source: is a file or an array (found {}); give the name of a file, or an array"
    for call, refusal in [
        (lambda: kiln.convert(volume[...], None), "out: is a folder (found NoneType); name the store to make"),
        (lambda: kiln.convert(3, "a.kiln"), source.format("int")),
        (lambda: kiln.open(None), source.format("NoneType")),
        (lambda: kiln.open("a.npy", store=3), "store: is a folder (found int); name the folder for stores"),
        (lambda: kiln.render(3), "job: is a dict or a file (found int); give the job's object"),
        (lambda: kiln.view(volume, job=3), "job: is a file (found int); name the file to write"),
        (lambda: volume.render(size=(8, 8)).save(3), "path: is a file (found int); name the picture to write"),
    ]:
        with pytest.raises(kiln.Error) as failure:
            call()
        assert str(failure.value).startswith(refusal), str(failure.value)
        assert (failure.value.code, failure.value.path) == ("usage", None)
    assert os.listdir() == []


def test_damaged_words_are_refused():
    with pytest.raises(ValueError, match="affine"):
        kiln.convert("a.npy", "a.kiln", affine=numpy.eye(4))
    with pytest.raises(kiln.Error, match="an open volume"):
        kiln.convert(kiln.open(numpy.zeros((4, 4, 4), "uint8")), "a.kiln")
    with pytest.raises(kiln.Error, match="nearest is dims"):
        kiln.convert("a.npy", "a.kiln", dim="1,2,3")
    for dtype in ("uint8", "int64", "float32", ">u2"):
        with pytest.raises(kiln.Error, match=r"shape: expected at least one voxel .*found 0 x 4 x 4") as failure:
            kiln.open(numpy.zeros((0, 4, 4), dtype))
        assert failure.value.code == "usage"

    class Chunked:  # as Dask's arrays
        shape, dtype, chunks = (0, 4, 4), numpy.dtype("uint8"), ((0,), (4,), (4,))

        def __getitem__(self, _):
            return numpy.zeros(self.shape, self.dtype)

    with pytest.raises(kiln.Error, match=r"shape: expected at least one voxel .*found 0 x 4 x 4"):
        kiln.open(Chunked())
