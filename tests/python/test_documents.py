"""What the manual's page and the examples show runs as it stands. Known: commands and scripts end without an error, and
write the files they name."""

import ast
import os
import pathlib
import re
import subprocess
import sys

import pytest

import kiln

SOURCE = pathlib.Path(__file__).parents[2]
PAGE = SOURCE / "tools/kiln/manual/python.md"
EXAMPLES = {"array_to_picture": "array.png", "turntable_sheet": "sheet.png", "ome_zarr_figure": "figure.png"}


def environment():
    """The program as `kiln`, and this interpreter as `python3`."""
    os.makedirs("bin", exist_ok=True)
    for name, program in (("kiln", os.environ["KILN"]), ("python3", sys.executable)):
        os.symlink(program, os.path.join("bin", name))
    return {**os.environ, "PATH": os.path.abspath("bin") + ":" + os.environ["PATH"], "PYTHONDONTWRITEBYTECODE": "1"}


def test_blocks_of_the_manual():
    text = PAGE.read_text(encoding="utf-8")
    blocks = re.findall(r"^```(sh run|sh python|python run)\n(.*?)^```$", text, re.S | re.M)
    assert [kind for kind, _ in blocks].count("python run") >= 7
    env, names = environment(), {}
    for kind, block in blocks:
        if kind == "python run":
            exec(compile(block, str(PAGE), "exec"), names)
        else:
            subprocess.run(["bash", "-e", "-c", block], env=env, check=True, capture_output=True)
    assert os.path.getsize("head.png") > 1000 and os.path.exists("turn_03.png") and os.path.exists("ones.kiln")
    assert text.count("\n") <= 150


def test_every_name_is_in_the_manual():
    text = PAGE.read_text(encoding="utf-8")
    for name in ("open", "convert", "render", "transfer_function", "view", "options", "Error", "Warning"):
        assert "kiln." + name in text, name
    for name in vars(kiln.Image).keys() | vars(kiln.Volume).keys():
        if not name.startswith("_") and name not in ("ndim", "planes", "normal", "value", "right", "path"):
            assert re.search(r"\b" + name + r"\b", text), name


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples(name):
    script = SOURCE / "tools/python/examples" / (name + ".py")
    done = subprocess.run([sys.executable, "-W", "error", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert os.path.getsize(EXAMPLES[name]) > 5000
    assert script.read_text().count("# %%") >= 4


def test_stubs_describe_the_module():
    """Names and members of the stub are those of the module."""
    from kiln import _kiln

    stub = ast.parse((SOURCE / "tools/python/kiln/_kiln.pyi").read_text())
    classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in stub.body if isinstance(node, ast.FunctionDef)}
    bound = {name for name in vars(_kiln) if not name.startswith("_")}
    assert bound == (classes.keys() - {"Facts"}) | functions | {"version", "job_format"}
    for name in bound & classes.keys():
        if name in ("Error", "Warning", "Floats"):
            continue
        members = {node.name for node in classes[name].body if isinstance(node, ast.FunctionDef)}
        members |= {node.target.id for node in classes[name].body if isinstance(node, ast.AnnAssign)}
        assert {member for member in vars(getattr(_kiln, name)) if not member.startswith("_")} == members - {"__init__"}


def test_every_example_is_run():
    assert {path.stem for path in (SOURCE / "tools/python/examples").glob("*.py")} == set(EXAMPLES)
