"""A design made up on the page: drawn at once, checked, and pressed or made by a process of its own."""

import io
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.core.run import LocalWorkers, Progress
from palpate.design import DomeSpec, MarkerSpec
from palpate.fea import WallSpec
from palpate.viewer.design_cache import CACHE_SIZE, DesignCache
from palpate.viewer.scene import describe_motion
from palpate.viewer.sketch import DesignDraft, bounds_of, build_preview
from palpate.viewer.work import press_archive, press_sketch


def tell_threads_and_go(path, progress):
    import os
    import threading

    Path(path).write_text(os.environ["OPENBLAS_NUM_THREADS"] + " " + str(os.getpid()))
    assert threading.active_count() > 1  # one looks for the parent
    time.sleep(600)


def test_a_worker_has_one_thread_and_goes_with_its_server(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    told = tmp_path / "told"
    script = (
        f"import sys, os, time; sys.path[:0] = {[str(Path(__file__).parents[up]) for up in (0, 2)]!r}\n"
        "from test_design_work import LocalWorkers, tell_threads_and_go\n"
        "if __name__ == '__main__':\n"
        "    pool = LocalWorkers(1)\n"
        f"    pool.submit(tell_threads_and_go, {str(told)!r})\n"
        f"    while not os.path.exists({str(told)!r}): time.sleep(0.02)\n"
        "    time.sleep(0.2); os._exit(0)\n"
    )
    server = tmp_path / "server.py"
    server.write_text(script)
    subprocess.run([sys.executable, str(server)], check=True, timeout=60)
    threads, worker = told.read_text().split()
    assert threads == "1"
    end = time.monotonic() + 10
    while Path(f"/proc/{worker}").exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert not Path(f"/proc/{worker}").exists()


def test_a_press_of_a_sketch_reports_its_depth():
    progress = Progress()
    sketch = DesignDraft(obstacle=WallSpec(depth=1.0))
    with LocalWorkers(1) as pool:
        pool.submit(press_sketch, sketch, progress=progress)
        ended = []
        while not ended:
            ended = pool.wait(1.0)
    assert ended[0][1].reason == ""
    assert ended[0][1].value.depth[-1] == pytest.approx(1.0)
    assert progress.share == pytest.approx(1.0)
    press = ended[0][1].value
    pytest.importorskip("meshio")
    with zipfile.ZipFile(io.BytesIO(press_archive(press))) as archive:
        increments = [f"press/press_{k:04d}.vtu" for k in range(len(press.depth))]
        assert set(archive.namelist()) == {"press/press.pvd", "press/force.csv", "press/contact.csv", *increments}
        assert len(archive.read("press/force.csv").splitlines()) == 1 + len(press.depth)


def test_a_sketch_is_drawn_at_rest_with_its_wall():
    drawn = build_preview(DesignDraft(obstacle=WallSpec(tilt_deg=5)))
    motion = drawn.specimen.pressed.at(5.0)
    assert motion.depths_mm.tolist() == [0.0]
    assert np.abs(motion.displacement).max() == 0
    assert describe_motion(drawn.specimen, motion)
    assert drawn.design.name == "H20 T2, 169 markers"


def test_a_camera_that_is_too_near_is_found():
    sketch = DesignDraft.model_validate({"camera": {"distance": 12}})
    assert build_preview(sketch).findings[0].code == "markers-out-of-sight"


def test_rings_beyond_the_dome_are_refused():
    with refused("markers-outside-skin"):
        build_preview(DesignDraft(markers=MarkerSpec(ring_diameters=(90.0,))))


def test_bounds_are_those_of_the_spec():
    assert bounds_of(DomeSpec, "height") == (2, 60)
    assert bounds_of(MarkerSpec, "diameter") == (0, 10)


def test_the_shelf_keeps_the_last_designs():
    shelf = DesignCache()
    drawn = build_preview(DesignDraft())
    names = [shelf.put(drawn.design, drawn.specimen) for _ in range(CACHE_SIZE + 1)]
    assert shelf.find(names[-1])[0] is drawn.design
    with refused("design-expired"):
        shelf.find(names[0])
