"""Calls: signals, threads, progress, memory. A picture drawn by several threads is known from one thread."""

import ctypes
import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import kiln

SIZE = {"size": (64, 48)}


class HeapInfo(ctypes.Structure):
    """struct mallinfo2 of glibc."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost",
        )
    ]


def live_bytes():
    """Bytes that programs have taken from the heap and not given back, whatever the heap keeps of the system's memory."""
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = HeapInfo
    found = mallinfo2()
    return found.uordblks + found.hblkhd


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_eight_threads_draw_at_once(head):
    s = kiln.open(head)
    words = [{"azimuth": 45 * i, "tf": ("ct-bone", "grayscale")[i % 2]} for i in range(8)]
    alone = [numpy.array(kiln.open(head).render(**one, **SIZE)) for one in words]
    found = {}

    def draw(i):
        for turn in range(3):
            found[i, turn] = numpy.array(s.render(**words[(i + turn) % 8], **SIZE))
            assert (s[10:20, 30, ::3] >= 0).all()

    threads = [threading.Thread(target=draw, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 24
    for (i, turn), pixels in found.items():
        assert (pixels == alone[(i + turn) % 8]).all()


def test_frames_are_drawn_by_one_call_at_a_time(head):
    """A call from another thread, or from a report of progress, is refused; the frames go on in their order."""
    job = {"volume": str(head), "image": {"width": 512, "height": 512}, "camera": {"turntable": {"frames": 2}}}
    refused = []

    def refuse(call):
        with pytest.raises(kiln.Error, match="one call at a time") as failure:
            call()
        refused.append(failure.value.code)

    def report(*_):
        if len(refused) < 6:
            refuse(lambda: next(frames))
            refuse(frames.run)
            thread = threading.Thread(target=refuse, args=(lambda: next(frames),))
            thread.start()
            thread.join()

    frames = kiln.render(job, progress=report)
    assert [image.frame for image in frames] == [1, 2]
    assert len(refused) in (3, 6) and set(refused) == {"usage"}


def test_python_runs_while_a_picture_is_drawn(head):
    """The lock is free while Kiln works: a thread of Python gets on."""
    counted, ended = [0], threading.Event()

    def count():
        while not ended.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    s = kiln.open(head)
    thread.start()
    time.sleep(0.02)
    before, begin = counted[0], time.perf_counter()
    s.render(size=(512, 512), samples=16)
    seconds, during = time.perf_counter() - begin, counted[0] - before
    ended.set()
    thread.join()
    assert during >= min(20, 50 * seconds), (during, seconds)


def interrupted(work):
    """Runs work and sends the signal of Ctrl-C after 0.3 s. Returns the time from the signal to its exception."""
    at = []

    def kill():
        at.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, kill)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        work()
        time.sleep(5)  # the work was too quick
    timer.join()
    return time.perf_counter() - at[0]


class Slow:
    """Zeros in chunks; each slice takes some time."""

    shape, dtype, chunks = (64, 640, 640), numpy.dtype("uint8"), (16, 16, 16)

    def __init__(self, seconds):
        self.seconds = seconds

    def __getitem__(self, key):
        time.sleep(self.seconds)
        return numpy.zeros([one.stop - one.start for one in key], "uint8")


def test_ctrl_c_cancels(head):
    s = kiln.open(head)
    plain = numpy.array(s.render(**SIZE))
    drawing = lambda: s.render(size=(4096, 4096), samples=16, sample_distance=0.25, interpolation="cubic", tf="fog")
    # Generous: the machine may be busy. Without cancelling the picture takes minutes.
    assert interrupted(drawing) < 10
    assert (numpy.asarray(s.render(**SIZE)) == plain).all(), "the cache works on"

    assert interrupted(lambda: kiln.convert(Slow(0.05), "slow.kiln", brick_size=16)) < 10


def test_progress(head):
    seen = []
    kiln.open(head).render(progress=lambda *report: seen.append(report), size=(512, 512), samples=4)
    kiln.convert(numpy.zeros((64, 64, 64), "u1"), "a.kiln", brick_size=16, progress=lambda *report: seen.append(report))
    assert seen and all(isinstance(step, str) and 0 <= done <= total for step, done, total in seen)

    class Enough(Exception):
        pass

    def stop(*report):
        raise Enough

    with pytest.raises(Enough):
        kiln.convert(Slow(0.02), "b.kiln", brick_size=16, progress=stop)


def test_200_frames_leak_nothing(head):
    s = kiln.open(head)
    array = s[...]

    def draw(count):
        for i in range(count):
            image = s.render(azimuth=i, aov=["depth"], **SIZE)
            assert numpy.asarray(image).shape and image.depth.shape and image.srgb8().shape and image._repr_png_()
            if i % 10 == 0:
                kiln.open(array).render(**SIZE)
            try:
                s.render(fov=1000)
            except kiln.Error:
                pass

    draw(40)  # caches, pools of buffers and of the allocator
    gc.collect()
    live, resident = live_bytes(), resident_bytes()
    draw(200)
    gc.collect()
    grown, resident_grown = live_bytes() - live, resident_bytes() - resident
    print("grown by", grown, "bytes on the heap,", resident_grown, "bytes resident")
    # 1.3 KiB a picture, which takes 74 KiB with its planes; measured: 6 KiB in all.
    assert grown < 256 << 10
    # Buffers in pages of 2 MiB are not on the heap. Free memory that the heap keeps grew by up to 8 MiB.
    assert resident_grown < 64 << 20


def test_arrays_outlive_their_names():
    """An array is kept by the volume, and released with it."""
    released = []

    class Kept(numpy.ndarray):
        def __del__(self):
            released.append(True)

    array = numpy.random.default_rng(1).integers(0, 255, (20, 20, 20), "uint8").view(Kept)
    copy = numpy.array(array)
    s = kiln.open(array)
    del array
    gc.collect()
    assert (s[...] == copy).all() and not released[1:]
    del s
    gc.collect()
    assert released


def test_errors_in_threads_and_at_the_end_of_python(head):
    """Python ends while a volume, a picture and a viewer are open, and a thread draws."""
    program = f"""
import threading, kiln, numpy
class Lazy:
    shape, dtype, chunks = (64, 64, 64), numpy.dtype("uint8"), (32, 32, 32)
    def __getitem__(self, key): return numpy.ones([one.stop - one.start for one in key], "uint8")
s, lazy, shown = kiln.open({str(head)!r}), kiln.open(Lazy(), brick_size=32), kiln.view({str(head)!r})
image = s.render(size=(32, 32))
lazy.render(size=(32, 32), tf="fog")
threading.Thread(target=lambda: s.render(size=(512, 512)), daemon=True).start()
try: s.render(fov=1000)
except kiln.Error as error: print(error.code)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "usage\n"), done.stderr
