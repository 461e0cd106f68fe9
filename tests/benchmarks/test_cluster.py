"""The Slurm of one node as far as it goes without one; `make cluster-test` runs it."""

import shutil
from pathlib import Path

import pytest

from benchmarks import cluster
from benchmarks.__main__ import main
from vsb.errors import VsbError
from vsb.study.campaign import Campaign


def test_without_slurm_it_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cluster.shutil, "which", lambda name, path: None if name == "munged" else f"/bin/{name}")
    assert main(["cluster", str(tmp_path / "runs")]) == 2
    line = "Slurm is not installed, munged not found; needs, on Debian, apt-get install slurm-wlm munge"
    assert capsys.readouterr().err == f"vsb: error: cluster: {line}\n"
    assert not (tmp_path / "runs").exists()


def test_all_its_files_lie_in_its_folder():
    text = cluster.configuration(Path("/here"), "node", "me", (7001, 7002), 2)
    given = dict(line.split("=", 1) for line in text.splitlines())
    places = [value for key, value in given.items() if key.endswith(("Location", "Dir", "LogFile", "PidFile"))]
    assert len(places) == 6
    assert all(place.startswith("/here/") for place in (*places, given["AuthInfo"].removeprefix("socket=")))
    assert given["SlurmUser"] == given["SlurmdUser"] == "me"


def test_its_campaign_is_one_of_several_batches():
    assert Campaign.model_validate(cluster.CAMPAIGN).vary.shape == (100, 4)


def test_other_bytes_are_told(tmp_path):
    for name in ("here", "there"):
        (tmp_path / name / "results" / "shells").mkdir(parents=True)
        for product in cluster.PRODUCTS:
            (tmp_path / name / "results" / "shells" / product).write_text(product)
    assert cluster._same(tmp_path, "there") == "the same bytes"
    (tmp_path / "there" / "results" / "shells" / "campaign.csv").write_text("other")
    assert cluster._same(tmp_path, "there") == "other bytes in campaign.csv"


def test_a_run_that_fails_names_its_log(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    with pytest.raises(VsbError, match=r"broken: ended with 2; see broken\.log beside it"):
        cluster._ran(tmp_path, "broken", dict(cluster.os.environ), config="absent.yaml")
    assert "absent.yaml" in (tmp_path / "broken.log").read_text()


def test_what_does_not_come_is_not_waited_for():
    with pytest.raises(VsbError, match="cluster: no node"):
        cluster._wait(lambda: False, 0.0, "no node")


@pytest.mark.skipif(shutil.which("slurmctld", path="/usr/sbin") is None, reason="Slurm is not installed")
def test_a_cluster_runs_jobs_and_is_gone(tmp_path):
    with cluster.slurm() as environment:
        found = cluster.subprocess.run(
            ["srun", "echo", "done"], env=environment, capture_output=True, text=True, timeout=60, check=True
        )
        folder = Path(environment["SLURM_CONF"]).parent
        assert found.stdout == "done\n"
    assert not folder.exists()
