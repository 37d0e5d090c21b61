"""Jobs, transfer functions and the viewer, against the program."""

import json
import os
import subprocess
import threading
import urllib.request

import numpy
import pytest

import kiln
from conftest import run_tool

JOB = {"image": {"width": 64, "height": 48}, "camera": {"turntable": {"frames": 4}}, "transferFunction": "ct-bone"}


def test_frames_equal_the_programs(head):
    job = {"kiln": 2, "volume": str(head), **JOB, "output": "python_####.png"}
    json.dump({**job, "output": "tool_####.png"}, open("job.json", "w"))
    run_tool("render", "job.json", cwd=".")
    frames = kiln.render(job)
    assert len(frames) == 4
    drawn = list(frames)
    assert [image.frame for image in drawn] == [1, 2, 3, 4]
    for i in range(1, 5):
        assert open(f"tool_{i:04}.png", "rb").read() == open(f"python_{i:04}.png", "rb").read() == drawn[i - 1]._repr_png_()
    again = [numpy.asarray(image) for image in kiln.render({**job, "volume": kiln.open(head), "output": "open_####.png"})]
    assert all((a == numpy.asarray(b)).all() for a, b in zip(again, drawn)) and os.path.exists("open_0004.png")
    os.remove("tool_0002.png")
    assert kiln.render("job.json").run(resume=True)[:3] == ([2], [1, 3, 4], [])


def test_several_volumes(head):
    array = kiln.open(head)[...]
    place = {"affine": kiln.open(head).affine, "unit": "mm", "frame": kiln.open(head).frame}
    job = {"image": {"width": 64, "height": 48}}
    of_program = {**job, "kiln": 2, "volumes": [{"volume": str(head)}, {"volume": "b.kiln"}], "output": "tool.exr"}
    job["volumes"] = [{"volume": kiln.open(head)}, {"volume": kiln.open(array, **place)}]
    kiln.convert(array, "b.kiln", **place)
    json.dump(of_program, open("job.json", "w"))
    run_tool("render", "job.json", cwd=".")
    (image,) = kiln.render(job)
    (of_files,) = kiln.render("job.json")
    assert (numpy.asarray(image) == numpy.asarray(of_files)).all()


def test_words_of_several_volumes_and_frames(head):
    s, size = kiln.open(head), {"size": (64, 48)}
    flags = ["--size", "64x48", "--tf", "ct-skin", "--add", head, "--add-tf", "ct-bone"]
    run_tool("render", head, "-o", "tool.png", *flags, cwd=".")
    bone = kiln.transfer_function("ct-bone")
    for added in (kiln.open(head), str(head)):
        assert s.render(tf="ct-skin", add=added, add_tf=bone, **size)._repr_png_() == open("tool.png", "rb").read()
    alone = s.render(**size)
    assert (numpy.asarray(alone) == numpy.asarray(kiln.open(head).render(**size))).all()
    with pytest.raises(kiln.Error, match="--add-tf"):
        s.render(add_tf="ct-bone", **size)
    run_tool("render", head, "-o", "t_#.png", "--size", "64x48", "--turntable", 4, cwd=".")
    frames = list(s.frames(turntable=4, **size))
    assert [image._repr_png_() for image in frames] == [open(f"t_{i}.png", "rb").read() for i in range(1, 5)]
    assert [image.frame for image in s.frames(turntable=4, frames="2-3", **size)] == [2, 3]


def test_functions_of_added_volumes_have_all_forms_of_tf(head):
    s = kiln.open(head)
    points = [(1000, 0), (1300, 0.5, "orange")]
    function = {
        "points": [
            {"value": 1000, "opacity": 0, "color": "orange"},
            {"value": 1300, "opacity": 0.5, "color": "orange"},
        ]
    }
    words = {"size": (64, 48), "tf": "ct-skin"}

    def drawn(added, functions):
        return numpy.asarray(s.render(add=added, add_tf=functions, **words))

    expected = drawn([head], "1000:0,1300:0.5:orange")
    for form in (points, [points], numpy.array([p[:2] for p in points]), function, [function]):
        if isinstance(form, numpy.ndarray):
            assert (drawn([head], form) == drawn([head], "1000:0,1300:0.5")).all()
        else:
            assert (drawn([head], form) == expected).all()
    assert (drawn([head, head], [points, "ct-bone"]) == drawn([head, head], ["1000:0,1300:0.5:orange", "ct-bone"])).all()


def test_wrong_jobs(head):
    for job in ({"volume": str(head), "imag": {}}, {"volume": "absent.kiln"}, {"volume": str(head), "output": "a.txt"}):
        with pytest.raises(kiln.Error):
            list(kiln.render(job))
    with pytest.raises(kiln.Error) as failure:
        kiln.render("absent.json")
    assert (failure.value.code, failure.value.path) == ("not_found", "absent.json")
    with pytest.raises(kiln.Error, match="open volumes"):
        kiln.render({"volume": kiln.open(head)}).run()


def test_transfer_functions(head):
    s = kiln.open(head)
    size = {"size": (64, 48)}

    def pixels(tf):
        return numpy.asarray(s.render(tf=tf, **size))

    assert (pixels(kiln.transfer_function("ct-bone")) == pixels("ct-bone")).all()
    points = kiln.transfer_function([(1100, 0), (1300, 0.5, "#ff8800"), (2000, 0.9, (1, 1, 1))])
    assert (pixels(points) == pixels("1100:0,1300:0.5:#f80,2000:0.9:white")).all()
    points.save("points.json")
    assert (pixels("points.json") == pixels(points)).all()

    def grey(place):  # as a colour map of Matplotlib
        return (place, place, place, 1.0)

    low, high = s.range
    stretched = kiln.transfer_function(grey, opacity=(0, 0.5))
    fixed = kiln.transfer_function(grey, range=(low, high), opacity=lambda place: 0.5 * place)
    assert numpy.abs(pixels(stretched) - pixels(fixed)).max() < 1e-5 and pixels(fixed).max() > 0
    with pytest.raises(kiln.Error):
        s.render(tf=kiln.transfer_function([(2, 0), (1, 1)]), **size)


def test_colour_maps_without_range_span_the_volume(head):
    s, size = kiln.open(head), {"size": (64, 48)}
    half = kiln.open(s[...] // 2, affine=s.affine, unit="mm", frame=s.frame)

    def function(of=None):
        return kiln.transfer_function(lambda t: (t, 1 - t, t, 1), range=of and of.range, opacity=(0, 0.5))

    def pixels(image):
        return numpy.asarray(image)

    def job(*functions):
        several = [{"volume": v, "transferFunction": f} for v, f in zip((s, half), functions)]
        return pixels(*kiln.render({"image": JOB["image"], **(several[0] if len(several) == 1 else {"volumes": several})}))

    assert (job(function()) == job(function(s))).all() and job(function(s)).max() > 0
    assert (job(function(), function()) == job(function(s), function(half))).all()
    for words in ({"add": half}, {"add": [s, half]}):
        volumes = words["add"] if isinstance(words["add"], list) else [words["add"]]
        found = s.render(tf="fog", add_tf=[function() for _ in volumes], **words, **size)
        known = s.render(tf="fog", add_tf=[function(one) for one in volumes], **words, **size)
        assert (pixels(found) == pixels(known)).all()
    for refused in (
        lambda: kiln.render({"volume": str(head), "transferFunction": function()}),
        lambda: kiln.render({"volumes": [{"volume": s}], "transferFunction": function()}),
        lambda: function().json(),
        lambda: function().save("map.json"),
    ):
        with pytest.raises(kiln.Error, match="range: .*; give range") as failure:
            refused()
        assert failure.value.code == "usage"
    assert not os.path.exists("map.json")
    nothing = kiln.open(numpy.full((8, 8, 8), numpy.nan, "f4"))
    with pytest.warns(kiln.Warning, match="transparent"):
        assert pixels(nothing.render(tf=function(), **size)).max() == 0


def test_files_become_stores_once(head):
    numpy.save("a.npy", kiln.open(head)[...])
    s = kiln.open("a.npy", spacing=(2, 1, 1))
    assert s.path == "a.npy.kiln" and s.spacing == (2, 1, 1)
    made = os.stat("a.npy.kiln/manifest.json").st_mtime_ns
    kiln.open("a.npy", spacing=(2, 1, 1))
    assert os.stat("a.npy.kiln/manifest.json").st_mtime_ns == made
    assert kiln.open("a.npy", store="stores").path.startswith("stores")
    run_tool("render", "a.npy", "-o", "a.png", "--size", "32x32", cwd=".")


def test_names_that_are_not_utf8():
    """Known: os.fsdecode gives such names, and no JSON can hold them."""
    folder = os.fsdecode(b"gr\xfcn")
    os.mkdir(folder)
    path = os.path.join(folder, "a.kiln")
    s = kiln.convert(numpy.indices((8, 8, 8))[0].astype("u1"), path)
    assert s.path == path and kiln.open(path).path == path
    words = {"image": {"width": 16, "height": 16}}
    expected = numpy.asarray(s.render(size=(16, 16)))
    assert (numpy.asarray(next(kiln.render({"volume": s, **words}))) == expected).all()
    with pytest.raises(kiln.Error, match="UTF-8") as failure:
        kiln.render({"volume": path, **words})
    assert failure.value.code == "usage"
    with pytest.raises(kiln.Error, match="xfcn") as failure:
        kiln.open(path + "x")
    assert failure.value.code == "not_found" and failure.value.path == path + "x"
    assert str(failure.value).isascii()
    with pytest.warns(kiln.Warning):
        kiln.open(path).render(size=(16, 16), tf="iso:9000")
    memmap = numpy.memmap(os.path.join(folder, "a.raw"), "u1", "w+", shape=(8, 8, 8))
    assert kiln.convert(memmap, os.path.join(folder, "b.kiln")).shape == (8, 8, 8)
    with kiln.view(s) as viewer:
        assert viewer.url.startswith("http")
    kiln.transfer_function([(0, 0), (7, 1)]).save(os.path.join(folder, "tf.json"))
    by_file = s.render(tf=os.path.join(folder, "tf.json"), size=(16, 16))
    assert (by_file.srgb8() == s.render(tf=[(0, 0), (7, 1)], size=(16, 16)).srgb8()).all()


def test_viewer_answers(head):
    with kiln.view(kiln.open(kiln.open(head)[...]), tf="ct-bone", job="look.json") as viewer:
        address, token = viewer.url.split("#")
        with urllib.request.urlopen(address, timeout=20) as page:
            assert b"<html" in page.read()
            assert "localhost" in page.headers["Content-Security-Policy"] and page.headers["X-Frame-Options"] is None
        assert viewer.url in viewer._repr_html_() and "<iframe" in viewer._repr_html_()
    with pytest.raises(OSError):
        urllib.request.urlopen(address, timeout=20)
    with pytest.raises(kiln.Error, match="json"):
        kiln.view(head, job="look.txt")
    assert not os.path.exists("look.json")


def test_viewer_shows_several_volumes(head):
    other = kiln.open(numpy.full((8, 8, 8), 3, "u1"), labels=True)
    with kiln.view(kiln.open(head), add=[head], labels=[other], add_tf=["ct-bone"]) as viewer:
        address, token = viewer.url.split("#")
        request = urllib.request.Request(f"{address}api/session", headers={"Authorization": f"Bearer {token}"})
        with urllib.request.urlopen(request) as answer:
            session = json.load(answer)
    assert [volume["classes"] for volume in session["volumes"]] == ["values", "values", "labels"]
    assert session["job"]["volumes"][1]["transferFunction"] == "ct-bone"


def test_documentation_and_types():
    for name in kiln.__all__:
        assert getattr(kiln, name).__doc__, name
    for option in kiln.options():
        assert option.help and option.flag.startswith("--")
    folder = os.path.dirname(kiln.__file__)
    assert os.path.exists(os.path.join(folder, "py.typed"))


def test_words_take_objects_of_a_job(head):
    """An object under an option's word is the object under the job's key."""
    size = {"size": (48, 40)}
    points = [{"value": 1000, "opacity": 0, "color": "white"}, {"value": 1300, "opacity": 0.5, "color": "orange"}]
    lamp = {"type": "point", "position": [0, -500, 0]}
    s = kiln.open(head)
    pictures = lambda *words: [numpy.asarray(s.render(**each, **size)) for each in words]
    by_option, by_key = pictures({"tf": {"points": points}}, {"transferFunction": {"points": points}})
    assert (by_option == by_key).all()
    tuples, text = pictures({"tf": [(1000, 0), (1300, 0.5, "orange")]}, {"tf": "1000:0,1300:0.5:orange"})
    assert (tuples == text).all()
    one, several = pictures({"tf": "ct-bone", "light": lamp}, {"tf": "ct-bone", "lights": [lamp]})
    assert (one == several).all()
    by_option, by_key = pictures(*({key: {"volume": str(head)}} for key in ("color_by", "colorBy")))
    assert (by_option == by_key).all()


def test_videos(head, tmp_path, monkeypatch):
    """A substitute for ffmpeg stores its input: known because raw frames have the size of the job's."""
    (tmp_path / "ffmpeg").write_text(
        '#!/bin/sh\ncase "$*" in *ffmetadata*) exit 1;; esac\nfor last; do :; done\ncat > "${last#file:}"\n'
        f"[ ! -e {tmp_path}/fail ]\n"
    )
    (tmp_path / "ffmpeg").chmod(0o700)
    job = {"volume": str(head), "image": {"width": 16, "height": 16}, "camera": {"turntable": {"frames": 3}}}
    with monkeypatch.context() as patched:
        patched.setenv("PATH", "relative::.")
        with pytest.raises(kiln.Error, match="needs the program ffmpeg") as failure:
            kiln.render({**job, "output": "a.mp4"})
        assert failure.value.code == "not_found"
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert kiln.render({**job, "output": "run.mp4"}).run().drawn == [1, 2, 3]
    assert len([image.frame for image in kiln.render({**job, "output": "a.mp4"})]) == 3
    assert os.path.getsize("a.mp4") == os.path.getsize("run.mp4") == 3 * 16 * 16 * 3
    assert not os.path.exists("a.mp4.frames")
    # A frame whose video failed is drawn again when it is asked for again.
    frames = kiln.render({**job, "output": "b.mp4"})
    next(frames), next(frames)
    (tmp_path / "fail").touch()
    with pytest.raises(kiln.Error):
        next(frames)
    (tmp_path / "fail").unlink()
    assert next(frames).frame == 3 and next(frames, None) is None
    assert os.path.getsize("b.mp4") == 3 * 16 * 16 * 3
    for wrong in ({"volume": kiln.open(head)}, {"camera": {}}):
        with pytest.raises(kiln.Error, match="a video needs") as failure:
            kiln.render({**job, "output": "c.mp4", **wrong})
        assert failure.value.code == "usage"


def test_points_and_opacities_are_checked(head):
    s = kiln.open(head)
    for points in ([], [(1,)], [(1, 0, "red", 2)]):
        with pytest.raises(kiln.Error, match="points"):
            kiln.transfer_function(points)
    with pytest.raises(kiln.Error, match="tf: a point is"):
        s.render(tf=[(1,)])
    with pytest.raises(kiln.Error, match="opacity"):
        kiln.transfer_function(lambda t: (t, t, t), opacity=[])
    grey = lambda **words: kiln.transfer_function(lambda t: (t, t, t), **words).points
    assert grey(opacity=numpy.float32(0.5)) == grey(opacity=0.5)
    assert grey(range=numpy.array([1000, 2000])) == grey(range=(1000, 2000))


def test_values_of_jobs_are_those_of_words(head):
    """One job as the words of a picture and as the job of kiln.render."""
    s = kiln.open(head)
    camera = {"eye": numpy.array([400.0, -500, 1700]), "target": numpy.zeros(3) + [0, 0, 1700], "up": (0, 0, numpy.int8(1))}
    tf = kiln.transfer_function([(1000, 0), (1300, 0.5, "orange")])
    by_words = s.render(camera=camera, tf=tf, size=(32, 24))
    job = {"volume": s, "camera": camera, "transferFunction": tf, "image": {"width": 32, "height": 24}}
    assert (numpy.asarray(by_words) == numpy.asarray(next(kiln.render(job)))).all()
    for wrong in (s, {1, 2}, b"text"):
        with pytest.raises(TypeError, match="a job has texts"):
            s.render(camera={"eye": wrong})
    with pytest.raises(TypeError, match="a job has texts"):
        next(kiln.render({**job, "camera": {"eye": {1, 2}}}))
    with pytest.raises(kiln.Error, match="UTF-8"):
        s.render(annotations={"text": os.fsdecode(b"gr\xfcn")})


def test_the_viewer_refuses_what_the_program_refuses(head):
    s = kiln.open(head)
    with pytest.raises(kiln.Error, match="--part"):
        kiln.view(s, part="1/2")


def test_threads_may_stop_one_viewer(head):
    s = kiln.open(head)
    for _ in range(10):
        viewer = kiln.view(s)
        failures = []

        def stop():
            try:
                viewer.stop()
            except BaseException as failure:
                failures.append(failure)

        threads = [threading.Thread(target=stop) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert not failures
