"""Pictures equal those of the program: known because both describe one job, and the program writes its files."""

import os
import subprocess
import sys

import numpy
import pytest

import kiln
from conftest import run_tool

SIZE = {"size": (96, 72)}
JOBS = [
    {},
    {"view": "front", "azimuth": 20, "elevation": 10.5, "tf": "ct-bone"},
    {"eye": (400, -500, 1700), "fov": 25, "samples": 4},
    {"projection": "orthographic", "tf": "1100:0,1300:0.5:#f80,2000:0.9:white"},
    {"mode": "mip", "window": (1100, 800), "tf": "viridis", "aov": ["value"]},
    {"lattice": "voxel", "tf": "grayscale", "background": "navy"},
    {"tf": "iso:1300", "light": ["cam:-1,1,1", "headlight"], "shadows": True, "aov": ["depth", "normal"]},
    {"region": "10,10,10,80,70,60", "level": 1, "interpolation": "cubic"},
    {"look": "studio", "exposure": 0.5, "crop": "10,5,80,60", "background": "black:#336"},
    {"stereo": "both", "interocular": 60, "tf": None},
    {"scale_bar": True, "box": True, "legend": True, "text": "{voxels}", "background": "black"},
]


def flags_of(words):
    """The words as flags, written here once more so that the package's own translation is tested."""
    out = []
    for word, value in words.items():
        flag = "--" + word.replace("_", "-")
        if value is True:
            out.append(flag)
        elif value is not None:
            items = value if isinstance(value, (tuple, list)) else [value]
            if word == "light":
                out += [argument for item in items for argument in (flag, item)]
            else:
                out += [flag, ("x" if word == "size" else ",").join(map(str, items))]
    return out


@pytest.mark.parametrize("words", JOBS, ids=lambda words: "-".join(words) or "plain")
def test_picture_equals_the_programs(head, words):
    words = {**words, **SIZE}
    run_tool("render", head, "-o", "tool.exr", "--exr-type", "float", *flags_of(words), cwd=".")
    image = kiln.open(head).render(**words)
    image.save("python.exr", exr_type="float")
    assert open("tool.exr", "rb").read() == open("python.exr", "rb").read()
    flat = {word: value for word, value in words.items() if word != "aov"}
    run_tool("render", head, "-o", "tool.png", *flags_of(flat), cwd=".")
    image.save("python.png")
    assert open("tool.png", "rb").read() == open("python.png", "rb").read()
    assert open("tool.png", "rb").read() == image._repr_png_()


def test_masks_and_colours_are_those_of_each_picture(head):
    volume = kiln.open(head)
    words = {"tf": "ct-bone", **SIZE}
    plain = numpy.asarray(volume.render(**words)).copy()
    coloured = volume.render(color_by=f"{head}:viridis", **words)
    assert (numpy.asarray(coloured) != plain).any()
    run_tool("render", head, "-o", "coloured.png", "--tf", "ct-bone", "--color-by", f"{head}:viridis", "--size", "96x72", cwd=".")
    assert open("coloured.png", "rb").read() == coloured._repr_png_()
    assert (numpy.asarray(volume.render(**words)) == plain).all()
    with pytest.raises(kiln.Error, match="absent.kiln"):
        volume.render(mask="absent.kiln:1", **words)


def test_the_right_eye_is_saved_alone(head):
    pair = kiln.open(head).render(stereo="both", interocular=60, **SIZE)
    pair.right.save("right.png")
    run_tool("render", head, "-o", "tool.png", "--stereo", "right", "--interocular", "60", "--size", "96x72", cwd=".")
    assert open("right.png", "rb").read() == open("tool.png", "rb").read() == pair.right._repr_png_()


def test_saving_takes_options_of_files_alone(head):
    image = kiln.open(head).render(**SIZE)
    for words in ({"tf": "ct-bone"}, {"size": (5, 5)}, {"deep": True}, {"output": "other.png"}):
        with pytest.raises(kiln.Error, match="is no option of a file"):
            image.save("refused.png", **words)
    for name, text in (("", "name is empty"), ("a%V.png", "no pair")):
        with pytest.raises(kiln.Error, match=text):
            image.save(name)


def test_a_picture_is_no_video(head):
    with pytest.raises(kiln.Error, match="a video needs frames"):
        kiln.open(head).render(**SIZE).save("x.mp4")


def test_a_run_needs_names_of_files(head):
    with pytest.raises(kiln.Error, match="names no file"):
        kiln.render({"volume": str(head)}).run()


def test_pixels_are_those_of_the_files(head):
    image = kiln.open(head).render(tf="ct-bone", background="navy", exposure=1, **SIZE)
    light = numpy.asarray(image)
    assert light.shape == image.shape == (72, 96, 4) and light.dtype == numpy.float32
    assert light.ctypes.data == numpy.asarray(image).ctypes.data, "the picture was copied"
    assert not light.flags.writeable
    assert (light[..., 3] == 1).all()
    image.save("a.png")
    shown = subprocess.run(["oiiotool", "a.png", "-o", "a.ppm"], capture_output=True, text=True)
    assert shown.returncode == 0, shown.stderr
    bytes_of_file = numpy.frombuffer(open("a.ppm", "rb").read()[-72 * 96 * 3 :], dtype=numpy.uint8).reshape(72, 96, 3)
    assert (image.srgb8()[..., :3] == bytes_of_file).all()


def test_pixels_outlive_picture_and_volume(head):
    pixels = numpy.asarray(kiln.open(head).render(**SIZE))
    kept = pixels.copy()
    kiln.open(head).render(view="back", **SIZE)
    assert (pixels == kept).all()


def test_planes(head):
    image = kiln.open(head).render(tf="iso:1300", aov=["depth", "normal"], **SIZE)
    seen = numpy.isfinite(image.depth)
    assert 0.1 < seen.mean() < 0.9
    assert numpy.allclose(numpy.linalg.norm(image.normal[seen], axis=-1), 1, atol=1e-5)
    assert set(image.planes) >= {"Z", "depth.mean", "N.X", "N.Y", "N.Z"}
    with pytest.raises(AttributeError, match='aov=\\["value"\\]'):
        image.value


def test_objects_of_a_job_are_words(head):
    s = kiln.open(head)
    camera = {"view": "left", "fov": 40}
    assert (numpy.asarray(s.render(camera=camera, **SIZE)) == numpy.asarray(s.render(view="left", fov=40, **SIZE))).all()


def test_job_draws_the_picture_again(head):
    s = kiln.open(head)
    image = s.render(tf="ct-bone", azimuth=30, **SIZE)
    job = image.job
    again = s.render(**{key: job[key] for key in ("camera", "image", "transferFunction")})
    assert (numpy.asarray(image) == numpy.asarray(again)).all()


def test_memory_bounds_bricks_and_changes_no_pixel(head):
    s = kiln.open(head)
    assert (numpy.asarray(s.render(memory="24M", **SIZE)) == numpy.asarray(s.render(memory=1 << 30, **SIZE))).all()


def test_voxels(head):
    s = kiln.open(head)
    whole = s[...]
    assert whole.shape == s.shape == (64, 80, 96) and whole.dtype == s.dtype == numpy.uint16
    for key in [
        (slice(3, 20), slice(None, None, 2), 5),
        (slice(60, 2, -7), Ellipsis),
        (-1, slice(5, 5), slice(None)),
        (Ellipsis, slice(90, 200)),
        7,
    ]:
        assert (s[key] == whole[key]).all() and s[key].shape == whole[key].shape
    assert s.levels == ((64, 80, 96), (32, 40, 48), (16, 20, 24))
    assert s.read(1).shape == s.levels[1]
    assert s.read(1, ((1, 4), (2, 9), (3, 5))).shape == (3, 7, 2)
    with pytest.raises(IndexError):
        s[64]
    for box in ((0, 0, 0, 8, 8, 8), ((0, 8), (0, 8)), ((0, 8), (0, 8), ("a", 8))):
        with pytest.raises(ValueError, match="expected 3 pairs"):
            s.read(1, box)
    with pytest.raises(kiln.Error) as failure:
        s.read(0, ((0, 65), (0, 1), (0, 1)))
    assert failure.value.code == "usage"


def test_indices_are_those_of_sequences(head):
    s = kiln.open(head)
    for key in (None, 1.5, "a", (0, None), True, (0, False), numpy.True_):
        with pytest.raises(TypeError, match="indices of a volume"):
            s[key]
    with pytest.raises(TypeError, match="integer"):
        s.read(0.5, ((0, 1), (0, 1), (0, 1)))
    with pytest.raises(IndexError):
        s[s.shape[0]]


def test_a_volume_of_a_relative_name_outlives_its_folder_as_working_directory(head, monkeypatch):
    """Known: voxels and pictures do not depend on the working directory, and names in messages are those given."""
    monkeypatch.chdir(head.parent)
    s, whole = kiln.open("head.kiln"), kiln.open(head)
    os.mkdir(head.parent / "elsewhere")
    monkeypatch.chdir(head.parent / "elsewhere")
    assert s.path == "head.kiln"
    assert (s[30] == whole[30]).all()
    assert (numpy.asarray(s.render(**SIZE)) == numpy.asarray(whole.render(**SIZE))).all()
    job = {"volume": s, "image": {"width": 32, "height": 32}}
    assert numpy.asarray(next(kiln.render(job))).any()


def test_a_value_that_names_no_file_is_refused_by_its_word(head):
    calls = {
        "source": [lambda: kiln.open(None), lambda: kiln.open(3), lambda: kiln.convert(None, "a.kiln")],
        "out": [lambda: kiln.convert(head, None)],
        "job": [lambda: kiln.render(None), lambda: kiln.view(head, job=3)],
        "path": [lambda: kiln.open(head).render(size=(8, 8)).save(None)],
    }
    for word, refused in calls.items():
        for call in refused:
            with pytest.raises(kiln.Error, match=rf"^{word}: is a .+ \(found (NoneType|int)\); ") as failure:
                call()
            assert failure.value.code == "usage"


def test_facts(head):
    s = kiln.open(head)
    whole = s[...]
    assert s.range == (whole.min(), whole.max())
    counts, edges = s.histogram()
    assert counts.sum() == whole.size and len(edges) == len(counts) + 1
    assert edges[0] == whole.min() and edges[-1] == whole.max()
    assert s.unit == "mm" and s.labels is None
    assert numpy.allclose(numpy.linalg.norm(s.affine[:3, :3], axis=0), s.spacing[::-1])


def test_errors_have_code_and_path(head):
    cases = [
        (lambda: kiln.open("absent.kiln"), "not_found", "absent.kiln"),
        (lambda: kiln.open(head).render(memory="1M"), "budget", str(head)),
        (lambda: kiln.open(head).render(fov=400), "usage", None),
        (lambda: kiln.open(head).render(azimut=3), "usage", None),
        (lambda: kiln.open(head, dims="1,2,3"), "usage", str(head)),
    ]
    for call, code, path in cases:
        with pytest.raises(kiln.Error) as failure:
            call()
        assert (failure.value.code, failure.value.path) == (code, path), str(failure.value)
    with pytest.raises(kiln.Error, match="nearest is --azimuth"):
        kiln.open(head).render(azimut=3)
    with pytest.raises(kiln.Error, match="store"):
        kiln.open(head).render(**SIZE).save(head / "picture.png")
    assert not (head / "picture.png").exists()
    open("damaged.kiln", "w").close()
    with pytest.raises(kiln.Error):
        kiln.open("damaged.kiln")


def test_values_of_numpy_are_those_of_python(head):
    s = kiln.open(head)
    for plain, of_numpy in [
        (
            {"camera": {"eye": [0, -300, 0], "fov": 30}},
            {"camera": {"eye": numpy.array([0, -300, 0]), "fov": numpy.float32(30)}},
        ),
        ({"share_reads": True}, {"share_reads": numpy.bool_(True)}),
        ({"tf": [(1000, 0), (1300, 0.5)]}, {"tf": numpy.array([(1000, 0), (1300, 0.5)])}),
        (
            {"light": [{"type": "point", "position": [0, -500, 0]}]},
            {"light": [{"type": "point", "position": numpy.array([0, -500, 0])}]},
        ),
    ]:
        assert (numpy.asarray(s.render(**plain, **SIZE)) == numpy.asarray(s.render(**of_numpy, **SIZE))).all()
    with pytest.raises(TypeError, match="found Volume"):
        s.render(camera={"eye": s})


def test_volumes_and_large_arrays_are_no_texts(head):
    s = kiln.open(head)
    for word in ("mask", "color_by", "tf", "background", "text"):
        for value in (s, numpy.zeros((64, 64, 64)), numpy.zeros((64, 64))):
            if word == "tf" and value is not s and value.ndim == 2:
                continue  # points
            with pytest.raises(TypeError, match=f"^{word}: expected a text") as failure:
                s.render(**{word: value})
            assert len(str(failure.value)) < 200


def test_doubtful_picture_warns(head):
    with pytest.warns(kiln.Warning, match="empty"):
        kiln.open(head).render(tf="iso:9999", **SIZE)


def test_import_is_quick():
    """Measured: 0.14 s on two busy cores; a bound that only a blocking import exceeds."""
    seconds = subprocess.run(
        [sys.executable, "-c", "import time; t = time.time(); import kiln; print(time.time() - t)"],
        capture_output=True, text=True, check=True,
    )
    print("import takes", seconds.stdout)
    assert float(seconds.stdout) < 3


def test_a_plane_is_a_text_a_tuple_or_a_list(head):
    volume = kiln.open(head)
    forms = ["1,0,0,0", (1, 0, 0, 0), [1, 0, 0, 0], ["1,0,0,0"], [(1, 0, 0, 0)], numpy.array([1, 0, 0, 0])]
    pictures = [numpy.asarray(volume.render(clip=form, section=True, size=(48, 36))) for form in forms]
    assert pictures[0].any() and all(numpy.array_equal(pictures[0], picture) for picture in pictures)
    several = numpy.asarray(volume.render(clip=[(1, 0, 0, 0), "0,1,0,0"], size=(48, 36)))
    assert not numpy.array_equal(several, pictures[0])


def test_words_of_flags_are_true_or_false(head):
    """Known: a word of a flag has no other value on the command line, and a text is true in Python."""
    s = kiln.open(head)
    plain = numpy.asarray(s.render(**SIZE))
    for off in (False, numpy.False_, None, 0):
        assert (s.render(scale_bar=off, **SIZE).srgb8() == s.render(**SIZE).srgb8()).all()
    for text in ("off", "no", "on", b"off"):
        with pytest.raises(kiln.Error, match="scale_bar: takes True or False") as failure:
            s.render(scale_bar=text, **SIZE)
        assert failure.value.code == "usage"
    assert (plain == numpy.asarray(s.render(share_reads="off", **SIZE))).all()


def test_lists_are_written_as_on_the_command_line(head):
    s = kiln.open(head)
    names = s.render(aov=["depth", "normal"], **SIZE).planes.keys()
    for both in ("depth,normal", ("depth", "normal"), ["depth,normal"]):
        assert s.render(aov=both, **SIZE).planes.keys() == names


def test_arrays_and_copies_are_those_of_numpy(head):
    s = kiln.open(head)
    with pytest.raises(TypeError, match="found ndarray"):
        s[numpy.array([1, 2])]
    with pytest.raises(ValueError, match="whole numbers"):
        s.read(0, ((0.5, 2), (0, 3), (0, 3)))
    for read in (s, s.render(**SIZE)):
        with pytest.raises(ValueError, match="is a copy"):
            read.__array__(numpy.dtype("f8"), copy=False)
        assert read.__array__(numpy.dtype("f8")).dtype == "f8"
    assert s.render(**SIZE).__array__(copy=False).dtype == "f4"
