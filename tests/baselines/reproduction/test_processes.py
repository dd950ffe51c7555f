"""Jobs: in order, several at once, failures again at the end, and all stop on a signal."""

import signal
import subprocess
import sys
import time

import pytest

from npss_baselines.reproduction import processes
from npss_baselines.reproduction.processes import Job


def job(folder, name, code, minutes=1.0):
    return Job(name, [sys.executable, "-c", code], folder / "logs" / f"{name}.txt", minutes)


@pytest.fixture
def lines():
    return []


def test_jobs_start_in_order_with_one_thread(tmp_path, lines):
    code = "import os; open({!r}, 'a').write(os.environ['OMP_NUM_THREADS'])"
    jobs = [job(tmp_path, str(i), code.format(str(tmp_path / "order")) + f"; print({i})") for i in range(3)]
    assert processes.run(jobs, workers=1, say=lines.append) == []
    assert [line.split(":")[0] for line in lines] == ["0", "1", "2"]
    assert (tmp_path / "order").read_text(encoding="utf-8") == "111"
    assert [one.log.read_text(encoding="utf-8") for one in jobs] == ["0\n", "1\n", "2\n"]


def test_as_many_run_at_once_as_asked_for(tmp_path, lines):
    # Each waits until the other has begun: one after the other, they would wait for ever.
    code = "import pathlib, time\npathlib.Path({!r}).touch()\nwhile not pathlib.Path({!r}).exists(): time.sleep(.01)"
    first, second = str(tmp_path / "first"), str(tmp_path / "second")
    jobs = [job(tmp_path, "a", code.format(first, second)), job(tmp_path, "b", code.format(second, first))]
    assert processes.run(jobs, workers=2, say=lines.append) == []


def test_what_fails_runs_once_more_after_the_others(tmp_path, lines):
    flag = tmp_path / "flag"
    flaky = f"import pathlib, sys; p = pathlib.Path({str(flag)!r}); e = p.exists(); p.touch(); sys.exit(not e)"
    jobs = [job(tmp_path, "flaky", flaky), job(tmp_path, "bad", "raise SystemExit(3)"), job(tmp_path, "good", "")]
    assert [one.name for one in processes.run(jobs, workers=1, say=lines.append)] == ["bad"]
    assert [line.split()[0] for line in lines] == ["flaky:", "bad:", "good:", "flaky:", "bad:"]
    assert "run again at the end" in lines[0]
    assert str(jobs[1].log) in lines[-1]
    assert [processes.has_failed(one.log) for one in jobs] == [False, True, False]


def test_no_jobs_are_no_work(lines):
    assert processes.run([], workers=2, say=lines.append) == []
    assert lines == []


def test_a_signal_stops_all_processes(tmp_path):
    script = f"""
import sys, pathlib
from npss_baselines.reproduction import processes
from npss_baselines.runs.stopping import Stopped
folder = pathlib.Path({str(tmp_path)!r})
code = '''
import pathlib, signal, sys, time
def stop(*_):
    pathlib.Path(sys.argv[1]).with_suffix(".stopped").touch()
    sys.exit(1)
signal.signal(signal.SIGTERM, stop)
pathlib.Path(sys.argv[1]).touch()
time.sleep(60)
'''
jobs = [processes.Job(str(i), [sys.executable, "-c", code, str(folder / str(i))], folder / f"log{{i}}", 1.0)
        for i in range(3)]
try:
    processes.run(jobs, workers=2, say=print)
except Stopped as stopped:
    sys.exit(128 + stopped.signal)
"""
    process = subprocess.Popen([sys.executable, "-c", script])
    while not all((tmp_path / str(i)).exists() for i in range(2)):
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 128 + signal.SIGTERM
    assert all((tmp_path / f"{i}.stopped").exists() for i in range(2))
    assert not (tmp_path / "2").exists()


def test_the_share_done_counts_expected_minutes(tmp_path, lines, monkeypatch):
    shares = []

    class Recorded:
        def __init__(self, what):
            pass

        def __enter__(self):
            return shares.append

        def __exit__(self, *_):
            pass

    monkeypatch.setattr(processes, "Progress", Recorded)
    jobs = [job(tmp_path, "long", "", minutes=3.0), job(tmp_path, "short", "", minutes=1.0)]
    processes.run([*jobs, job(tmp_path, "last", "", minutes=0.0)], workers=1, say=lines.append)
    assert shares == sorted(shares)
    assert max(shares) <= 1
    assert min(abs(share - 0.75) for share in shares) < 0.01
