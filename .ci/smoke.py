"""What must hold of the built wheel, installed alone: run by .ci/run with the wheel and the project's folder as arguments."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path


def wheel_is_clean(wheel: Path, project: Path) -> None:
    """No test, no recording, nothing but the package: and what the package needs beside its code is there."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        sums = {hashlib.sha256(archive.read(name)).hexdigest() for name in names if not name.endswith("/")}
    strangers = [n for n in names if not n.startswith(("kinesics/", "kinesics-"))]
    assert not strangers, f"the wheel holds more than the package: {strangers}"
    figure = "kinesics/body/figure.npz"
    assert figure in names, "the wheel lacks the human figure that glTF files wear"
    kinds = (".bvh", ".amc", ".asf", ".c3d", ".fbx", ".avi", ".npz", ".glb", ".zip")
    recordings = [n for n in names if n.lower().endswith(kinds) and n != figure]
    assert not recordings, f"the wheel holds recordings: {recordings}"
    assert not [n for n in names if "test" in Path(n).name], "the wheel holds tests"
    assert any("_native" in n and n.endswith((".so", ".pyd")) for n in names), "the wheel lacks the compiled module"
    assert any(n.endswith("py.typed") for n in names), "the wheel lacks py.typed"
    assert any(n.endswith(".schema.json") for n in names), "the wheel lacks the JSON Schema of analysis.json"
    data = project.parent / "shared" / "data"
    for file in data.rglob("*") if data.is_dir() else ():
        if file.is_file() and file.stat().st_size < 20_000_000:
            assert hashlib.sha256(file.read_bytes()).hexdigest() not in sums, (
                f"the wheel holds {file.name} of the test data"
            )


def import_is_light_and_ours(project: Path) -> None:
    """The installed package is imported, not the source tree, and drags in no pictures."""
    import kinesics

    home = Path(kinesics.__file__).resolve()
    assert project.resolve() not in home.parents, f"the source tree was imported: {home}"
    heavy = {"matplotlib", "cv2", "scipy", "networkx"} & set(sys.modules)
    assert not heavy, f"`import kinesics` loads {heavy}"
    import kinesics._native


def command(*arguments: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Run the installed command."""
    script = Path(sys.executable).parent / "kinesics"
    done = subprocess.run([str(script), *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == code, (
        f"kinesics {' '.join(arguments)}: exit {done.returncode}\n{done.stdout}\n{done.stderr}"
    )
    return done


def the_main_job_runs(folder: Path) -> None:
    """Demo, conversion, analysis as JSON, a performance, and one clear message on a bad file."""
    import kinesics as kx

    os.chdir(folder)
    assert kx.__version__ in command("--version").stdout
    command("demo", "--out", "report")
    for name in ("analysis.json", "report.html", "zz.png", "zz-triangle.png"):
        assert (folder / "report" / name).stat().st_size > 0, f"demo left no {name}"
    kx.write(kx.performer.walk(seconds=4, fps=60).motion, "walk.bvh")
    command("convert", "walk.bvh", "again.bvh")
    result = json.loads(command("analyze", "again.bvh", "--json").stdout)
    assert result["sources"][0]["name"] == "again.bvh"
    command("perform", "walk.bvh", "--out", "new.glb", "--target", "0,3")
    assert kx.read("new.glb").frame_count > 30
    assert json.loads(Path("new.provenance.json").read_text(encoding="utf-8"))["goal"]["attained"]
    Path("bad.bvh").write_text("HIERARCHY\nROOT Hips\n{\n", encoding="utf-8")
    said = command("info", "bad.bvh", code=2)
    assert "bad.bvh" in said.stderr
    assert "Traceback" not in said.stderr


def main() -> None:
    """Run all, name each."""
    wheel, project = Path(sys.argv[1]), Path(sys.argv[2])
    folder = Path.cwd() / "work"
    folder.mkdir()
    wheel_is_clean(wheel, project)
    print("wheel: only the package, compiled module and schema inside")
    import_is_light_and_ours(project)
    print("import: light, from the wheel")
    the_main_job_runs(folder)
    print("demo, convert, analyze, perform, info: run from the wheel")


if __name__ == "__main__":
    main()
