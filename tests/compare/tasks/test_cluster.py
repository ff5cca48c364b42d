"""Surveys and studies on a Dask cluster: workers die, are old, or are not there."""

import os
import signal
import sys
from importlib.metadata import PackageNotFoundError

import pytest
from distributed import Client, LocalCluster
from fault_tasks import kill_me

import slipfront as sf
from compare.tasks import cluster
from compare.tasks.cluster import connected
from compare.tasks.workers import run_tasks
from semianalytic.scene.errors import ComputationError, SceneError
from slipfront.cli.commands import main
from slipfront.surveys import survey

SCENE = sf.find("preloaded")
VALUES = {"friction": [0.1, 0.2, 0.3, 0.5, 0.7, 0.9], "poisson_ratio": [0.1, 0.2, 0.45]}


def local_cluster(workers, processes=False):
    """A cluster on this machine, of threads of this process unless told otherwise."""
    return LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=processes,
        protocol="tcp",
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    )


@pytest.fixture(scope="module", params=[False])
def two_workers(request):
    with local_cluster(2, processes=request.param) as local:
        yield local


in_processes = pytest.mark.parametrize("two_workers", [True], indirect=True, ids=["processes"])
"""For tests in which a worker ends."""


@pytest.fixture
def client(two_workers):
    with Client(two_workers, set_as_default=False) as first:
        yield first


def plain(data):
    return data.drop_vars("seconds")


@pytest.mark.slow
@in_processes
def test_a_survey_whose_worker_is_killed_is_complete_and_equal(client, tmp_path):
    """Half way, while it has work and results."""
    known = survey(SCENE, chunk=1, workers=1, **VALUES)
    victims = []

    def kill_one(done, count):
        if done >= count // 2 and not victims:
            victims.append(min(client.run(os.getpid).values()))
            os.kill(victims[0], signal.SIGKILL)

    path = tmp_path / "a.nc"
    data = survey(SCENE, chunk=1, client=client, path=path, progress=kill_one, **VALUES)
    assert victims
    assert plain(data).identical(plain(known))
    client.wait_for_workers(2, timeout=60)
    assert victims[0] not in client.run(os.getpid).values()


def test_results_are_let_go_and_errors_come_back(client):
    tasks = [(pow, (2, k)) for k in range(30)]
    found = dict(run_tasks(tasks, client=client))
    assert found == {k: 2**k for k in range(30)}
    with pytest.raises(ZeroDivisionError):
        dict(run_tasks([(pow, (0, -1)), *tasks], client=client))
    assert dict(run_tasks(tasks[:3], client=client)) == {0: 1, 1: 2, 2: 4}


@pytest.mark.slow
@in_processes
def test_a_task_that_ends_every_worker_is_given_up(client):
    client.run(sys.path.append, str(os.path.dirname(kill_me.__code__.co_filename)))
    with pytest.raises(ComputationError, match="has ended several workers"):
        dict(run_tasks([(kill_me, ())], client=client))


@pytest.mark.parametrize(
    ("there", "said"),
    [("0.0.1", "has slipfront 0.0.1"), (PackageNotFoundError("slipfront"), "has no slipfront")],
)
def test_workers_of_another_version_are_refused(there, said, client, monkeypatch):
    monkeypatch.setattr(client, "run", lambda *_, **__: {"tcp://there:1": there})
    with pytest.raises(ComputationError, match=said) as raised:
        survey(SCENE, client=client, **VALUES)
    assert "\n" not in str(raised.value)


def test_a_cluster_without_workers_is_refused():
    with (
        local_cluster(0) as bare,
        Client(bare, set_as_default=False) as member,
        pytest.raises(ComputationError, match="has no workers"),
    ):
        cluster.check_workers(member, patience=0.2)


def test_an_address_nobody_answers_at_is_refused(two_workers):
    with (
        pytest.raises(ComputationError, match="No Dask scheduler answers at tcp:"),
        connected("tcp://127.0.0.1:1", patience=0.3),
    ):
        pass
    for address in ("nowhere", "carrier://pigeon", "127.0.0.1:1"):
        with pytest.raises(SceneError, match="must be an address"), connected(address):
            pass
    with connected(None) as nobody:
        assert nobody is None


def test_the_command_line_works_on_a_cluster(two_workers, tmp_path, capsys):
    path = tmp_path / "a.nc"
    line = "survey preloaded --friction 0.1,0.2 --quiet"
    address = two_workers.scheduler_address
    assert main([*line.split(), "--output", str(path), "--scheduler", address]) == 0
    assert path.is_file()
    assert "converged" in capsys.readouterr().out
