"""A Dask cluster inside the process of the tests, and study files."""

import pytest


@pytest.fixture(scope="session")
def scheduler():
    """Address of a scheduler in this process, with two workers that are threads of it."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0", silence_logs=40
    ) as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def study_file(tmp_path):
    """Writes a study of a scene, text or name, and says where."""

    def write(text, scene='scene = "one-mode"'):
        if "\n" in scene:
            (tmp_path / "scene.toml").write_text(scene, encoding="utf-8")
            scene = 'scene = "scene.toml"'
        path = tmp_path / "study.toml"
        path.write_text(f"{scene}\n{text}", encoding="utf-8")
        return path

    return write
