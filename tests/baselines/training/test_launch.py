"""Starting and stopping of training: signals, clusters, full disks, folders, estimates of time."""

import os
import shlex
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import torch
from filelock import FileLock
from lightning.pytorch.utilities.rank_zero import rank_zero_only

from disk import full_disk
from npss.console import _progress
from npss.extras import install_hint
from npss_baselines.commands import train, train_manifold, train_options
from npss_baselines.data import SOURCES, h36m
from npss_baselines.data.synthetic import synthetic_training_set, synthetic_validation
from npss_baselines.manifold.motion import prepared
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.training import config as manifold_config
from npss_baselines.manifold.training.loss import loss_of
from npss_baselines.models import MODELS
from npss_baselines.runs import checkpoint, config, fitting, folder, launch, weights
from npss_baselines.runs.stopping import Stop, Stopped
from npss_baselines.training import trainer
from outcomes import same
from registered import registered
from trainings import RECIPE, TINY, command, configured, outcome, train_a_command, trained

pytestmark = pytest.mark.usefixtures("_tiny")

OPTIONS = ["tiny", "--data", "synthetic", "--iterations", "4", "--validate-every", "2", "--recipe.batch", "2"]


@pytest.fixture
def signalled(monkeypatch):
    """Send a signal in the second iteration, while its loss is computed."""
    before = {}

    def at_second_iteration(number, times=1):
        # Under nohup, or in a shell's background job, the tests may ignore the signal, which training respects.
        default = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
        before[number] = signal.signal(number, default)
        loss = trainer.TrainingRun.loss

        def interrupted(member, poses, label, iteration):
            if iteration == 1 and not sent:
                for _ in range(times):
                    sent.append(number)
                    os.kill(os.getpid(), number)
            return loss(member, poses, label, iteration)

        sent = []
        monkeypatch.setattr(trainer.TrainingRun, "loss", interrupted)

    yield at_second_iteration
    for number, handler in before.items():
        signal.signal(number, handler)


# --- signals ---


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the outcome of an uninterrupted command."""
    out = tmp_path_factory.mktemp("whole") / "r"
    with registered(MODELS, tiny=TINY):
        assert command("train", *OPTIONS, "--out", out) == 0
    return outcome(out)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_stops_after_the_step_and_prints_how_to_resume(tmp_path, capsys, signalled, whole, name):
    number = getattr(signal, name)
    out = tmp_path / "a run"
    signalled(number)
    before = signal.getsignal(number)
    with pytest.raises(SystemExit) as ended:
        command("train", *OPTIONS, "--out", out, "--device", "cpu")
    assert ended.value.code == 128 + number
    captured = capsys.readouterr()
    assert captured.out == ""
    how = "interrupted" if name == "SIGINT" else f"stopped by {name}"
    assert captured.err == (
        f"npss-baselines: {how}; to resume: npss-baselines train --resume --out '{out}' --device cpu\n"
    )
    assert signal.getsignal(number) is before
    assert torch.load(out / config.CHECKPOINT, weights_only=True)["global_step"] == 2
    line = shlex.split(captured.err.partition("to resume: ")[2])
    assert line[0] == "npss-baselines"
    assert command(*line[1:]) == 0
    assert same(outcome(out), whole)


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2])
def test_signals_of_closed_terminals_and_batch_systems_stop_too(tmp_path, signalled, number):
    signalled(number)
    with pytest.raises(Stopped) as stopped:
        trained(tmp_path, configured())
    assert stopped.value.signal is number
    assert torch.load(tmp_path / config.CHECKPOINT, weights_only=True)["global_step"] == 2


def test_a_second_signal_stops_at_once(tmp_path, signalled):
    signalled(signal.SIGTERM, times=2)
    with pytest.raises(Stopped) as stopped:
        trained(tmp_path, configured("--checkpoint-every", "1"))
    assert stopped.value.signal is signal.SIGTERM
    assert torch.load(tmp_path / config.CHECKPOINT, weights_only=True)["global_step"] == 1


def test_a_signal_that_lightning_catches_first_is_not_a_success(tmp_path, monkeypatch):
    """Between the end of the step and Lightning's check of the signal, which exits with status 0."""
    done = fitting.Resumable.step_is_done

    def then_a_signal(module, *, checkpoint):
        done(module, checkpoint=checkpoint)
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(fitting.Resumable, "step_is_done", then_a_signal)
    with pytest.raises(Stopped) as stopped:
        trained(tmp_path, configured())
    assert stopped.value.signal is signal.SIGTERM


def test_the_exit_status_is_that_of_the_signal(tmp_path, processes):
    options = [
        "train",
        "vgru-d",
        *OPTIONS[1:],
        "--model.n_units",
        "4",
        "--recipe.n_target",
        "4",
        "--out",
        tmp_path / "r",
    ]
    process = processes.Process(target=train_a_command, args=(options, signal.SIGTERM))
    process.start()
    process.join()
    assert process.exitcode == 143


def test_ignored_signals_stay_ignored_and_other_threads_get_none():
    old = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # nohup
    try:
        with Stop() as stop:
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            os.kill(os.getpid(), signal.SIGHUP)
            stop.check()
    finally:
        signal.signal(signal.SIGHUP, old)
    before, inside = signal.getsignal(signal.SIGTERM), []

    def in_a_thread():
        with Stop():
            inside.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=in_a_thread)
    thread.start()
    thread.join()
    assert inside == [before]


def test_the_manifold_is_resumed_likewise(tmp_path, capsys, monkeypatch):
    options = ["manifold", "--quick", "--model.widths", "[4,5]", "--whole.epochs", "1", "--layers.epochs", "0"]
    assert command("train", *options, "--out", tmp_path / "whole") == 0
    loss, calls = loss_of, []

    def interrupted(*arguments, **options):
        calls.append(1)
        if len(calls) == 2:
            os.kill(os.getpid(), signal.SIGTERM)
        return loss(*arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr("npss_baselines.manifold.training.trainer.loss_of", interrupted)
        patch.setenv("SLURM_NTASKS", "8")
        patch.setenv("SLURM_JOB_NAME", "train.sh")
        with pytest.raises(SystemExit) as ended:
            command("train", *options, "--out", tmp_path / "m")
    assert ended.value.code == 143
    line = f"npss-baselines train manifold --resume --out {tmp_path / 'm'}"
    assert capsys.readouterr().err == f"npss-baselines: stopped by SIGTERM; to resume: {line}\n"
    assert command(*shlex.split(line)[1:]) == 0
    assert (tmp_path / "m" / weights.FILE).read_bytes() == (tmp_path / "whole" / weights.FILE).read_bytes()


# --- the environments of clusters ---

CLUSTERS = {
    "slurm": {"SLURM_NTASKS": "8", "SLURM_JOB_NAME": "train.sh", "SLURM_JOB_ID": "1", "SLURM_PROCID": "3"},
    "torchrun": {"TORCHELASTIC_RUN_ID": "1", "RANK": "3", "LOCAL_RANK": "3", "WORLD_SIZE": "8", "GROUP_RANK": "0"},
    "lsf": {"LSB_JOBID": "1", "JSM_NAMESPACE_SIZE": "8", "JSM_NAMESPACE_RANK": "3", "JSM_NAMESPACE_LOCAL_RANK": "3"},
    "kubeflow": {"KUBERNETES_PORT": "1", "MASTER_ADDR": "a", "MASTER_PORT": "1", "WORLD_SIZE": "8", "RANK": "3"},
    "mpi": {"OMPI_COMM_WORLD_SIZE": "8", "OMPI_COMM_WORLD_RANK": "3", "OMPI_COMM_WORLD_LOCAL_RANK": "3"},
}


@pytest.fixture
def cluster(monkeypatch):
    def enter(name):
        for variable, value in CLUSTERS[name].items():
            monkeypatch.setenv(variable, value)
        monkeypatch.setattr(rank_zero_only, "rank", 3)  # as when Lightning is imported in that environment

    return enter


@pytest.mark.parametrize("name", CLUSTERS)
def test_one_process_trains_in_every_environment(tmp_path, cluster, name):
    pytest.importorskip("tensorboard")
    expected = trained(tmp_path / "alone", configured("--iterations", "2"))
    cluster(name)
    (tmp_path / "run").mkdir()
    data = synthetic_training_set(3, 60), synthetic_validation(2)
    assert trainer.train(configured("--iterations", "2"), *data, tmp_path / "run", tensorboard=True) == expected
    assert list((tmp_path / "run" / "tensorboard").iterdir())  # which only the first process of a job writes


def test_no_signal_requeues_a_job(tmp_path, monkeypatch, cluster, signalled):
    called = tmp_path / "called"
    scontrol = tmp_path / "scontrol"
    scontrol.write_text(f"#!/bin/sh\ntouch {called}\n", encoding="utf-8")
    scontrol.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    cluster("slurm")
    signalled(signal.SIGUSR1)
    with pytest.raises(Stopped):
        trained(tmp_path / "run", configured())
    assert not called.exists()


# --- folders ---


def test_a_missing_device_leaves_no_folder(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    for options in (OPTIONS, ["manifold", "--quick"]):
        assert command("train", *options, "--device", "cuda", "--out", tmp_path / "r") == 2
        message = capsys.readouterr().err
        assert message.startswith("npss-baselines: error: --device cuda: ")
        assert message.endswith("; --device cpu trains without a GPU\n")
        assert message.count("\n") == 1
    assert not list(tmp_path.iterdir())
    assert launch.device_of("auto") == "cpu"


def test_a_failed_command_leaves_no_folder(tmp_path, capsys):
    diverging = ["--recipe.lr", "1e38", "--recipe.optimizer", "sgd", "--recipe.clip_norm", "null"]
    for wrong, message in (
        (["--recipe.n_seed", "600"], "windows of 605 frames, from frame 16 on, need at least 621"),
        ([*diverging, "--checkpoint-every", "2"], "has diverged by iteration 2"),
    ):
        assert command("train", *OPTIONS, *wrong, "--out", tmp_path / "new" / "r") == 2
        assert message in capsys.readouterr().err
        assert not list(tmp_path.iterdir())
    (tmp_path / "mine").write_text("kept", encoding="utf-8")
    assert command("train", *OPTIONS, *wrong, "--out", tmp_path) == 2
    assert [file.name for file in tmp_path.iterdir()] == ["mine"]


def test_errors_name_a_model_that_diverges_in_the_last_step(tmp_path):
    """The loss was of the weights before that step."""
    configuration = replace(configured(), recipe=replace(RECIPE, iterations=1, optimizer="sgd", lr=1e30))
    with pytest.raises(ValueError, match=r"^training of .* has diverged by iteration 1: .*; try a lower --recipe\.lr$"):
        trained(tmp_path, configuration)


def test_two_processes_cannot_train_into_one_folder(tmp_path, capsys):
    out = tmp_path / "r"
    assert command("train", *OPTIONS, "--out", out) == 0
    before = outcome(out)
    capsys.readouterr()
    with FileLock(out / launch.LOCK):  # held by the other process
        for options in (["--resume", "--out", out], [*OPTIONS, "--out", out, "--resume"]):
            assert command("train", *options) == 2
            assert capsys.readouterr().err == (f"npss-baselines: error: --out: another process is training in {out}\n")
    assert same(outcome(out), before)
    # Another process started and ended between the check of the folder and the lock.
    with (
        pytest.raises(ValueError, match=r"another process has trained in .* meanwhile"),
        launch.exclusive_folders(out, [out], before=[]),
    ):
        pass
    assert same(outcome(out), before)


def test_leftovers_of_a_killed_process_are_removed(tmp_path):
    part = tmp_path / f".{config.CHECKPOINT}.0123abcd.part"
    part.write_bytes(b"half")
    with launch.exclusive_folders(tmp_path, [tmp_path], before=[]):
        assert not part.exists()


# --- files ---


def test_training_resumes_after_a_full_disk(tmp_path, capsys):
    out, options = tmp_path / "r", [*OPTIONS, "--checkpoint-every", "1", "--model.units", "40"]
    with full_disk(20_000):
        assert command("train", *options, "--out", out) == 2
    line = f"npss-baselines train --resume --out {out}"
    assert capsys.readouterr().err == (
        f"npss-baselines: error: cannot write {out / config.CHECKPOINT}: File too large; to resume: {line}\n"
    )
    assert {file.name for file in out.iterdir()} == {config.FILE, launch.LOCK}
    assert command(*shlex.split(line)[1:]) == 0


@pytest.mark.parametrize("share", [0, 0.1, 0.5, 0.9, 0.999])
def test_errors_name_a_truncated_checkpoint(tmp_path, share):
    trained(tmp_path, configured("--iterations", "1"))
    content = (tmp_path / config.CHECKPOINT).read_bytes()
    (tmp_path / config.CHECKPOINT).write_bytes(content[: round(share * len(content))])
    with pytest.raises(ValueError, match=r"last\.ckpt: not a checkpoint, or an incomplete one"):
        trained(tmp_path, configured("--iterations", "2"))


def test_errors_name_an_invalid_checkpoint(tmp_path):
    torch.save({"state": 1}, tmp_path / config.CHECKPOINT)
    with pytest.raises(ValueError, match=r"last\.ckpt: not a checkpoint, .*no weights in it"):
        trained(tmp_path, configured())


# --- the folder of the data ---


def test_a_run_records_the_folder_of_its_data(tmp_path, capsys, monkeypatch):
    """It is used if no option names one, before the environment variable."""
    requested, here, moved = [], tmp_path / "h3.6m", tmp_path / "moved"
    here.mkdir()

    def data_of(configuration, root, cache):
        requested.append(root)
        if not root.exists():
            raise FileNotFoundError(f"{root}: no Human3.6M in it")
        (task,) = synthetic_validation(2)
        return synthetic_training_set(3, 60), [task._replace(action="walking")]

    monkeypatch.setattr(train, "data_of", data_of)
    monkeypatch.delenv("NPSS_H36M", raising=False)
    monkeypatch.chdir(tmp_path)
    options = ["tiny", "--iterations", "2"]
    assert command("train", *options, "--h36m", "h3.6m", "--out", "r") == 0
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setenv("NPSS_H36M", str(tmp_path))
    assert command("train", "--resume", "--out", tmp_path / "r") == 0
    assert command("train", "--config", tmp_path / "r" / config.FILE, "--out", "again") == 0
    assert command("train", *options, "--out", "other") == 0
    assert requested == [Path("h3.6m"), here, here, tmp_path]
    here.rename(moved)
    capsys.readouterr()
    assert command("train", "--resume", "--out", tmp_path / "r") == 2
    assert capsys.readouterr().err == (
        f"npss-baselines: error: {here}: no such folder; {tmp_path / 'r' / config.FILE} records it as "
        f"the folder of the data; --h36m DIR replaces it\n"
    )
    assert command("train", "--resume", "--out", tmp_path / "r", "--h36m", moved) == 0
    assert config.paths_of(tmp_path / "r" / config.FILE) == {"h36m": moved}
    several = [*options, "--seeds", "1", "2", "--out", tmp_path / "several"]
    assert command("train", *several, "--h36m", moved) == 0
    assert command("train", *several, "--resume") == 0
    assert requested[-1] == moved


def test_a_run_does_not_resume_with_other_motion(tmp_path):
    trained(tmp_path, configured("--iterations", "1"), synthetic_training_set(3, 60))
    with pytest.raises(ValueError, match=r"^--resume: .* was trained on other motion than this$"):
        trained(tmp_path, configured("--iterations", "2"), synthetic_training_set(3, 61))


def test_several_runs_resume_by_the_whole_command(tmp_path, capsys, signalled):
    several = [*OPTIONS, "--seeds", "1", "2", "--out", str(tmp_path / "s")]
    signalled(signal.SIGTERM)
    with pytest.raises(SystemExit):
        command("train", *several)
    line = f"npss-baselines train {shlex.join(several)} --resume"
    assert capsys.readouterr().err == f"npss-baselines: stopped by SIGTERM; to resume: {line}\n"
    assert command(*shlex.split(line)[1:]) == 0


def test_a_manifold_records_the_folders_of_its_motion(tmp_path, capsys, monkeypatch):
    requested, cmu, h36m = [], tmp_path / "cmu", tmp_path / "h36m"
    for root in (cmu, h36m):
        root.mkdir()
    walks = motion_set(quick=True)

    def motion(folders, **_):
        requested.append(folders)
        if not all(root.exists() for root in requested[-1].values()):
            raise FileNotFoundError("no clips")
        return walks

    monkeypatch.setattr(train_manifold, "motion_set", motion)
    options = ["manifold", "--quick", "--model.widths", "[4,5]", "--whole.epochs", "1", "--layers.epochs", "0"]
    assert command("train", *options, "--cmu", cmu, "--h36m", h36m, "--out", tmp_path / "m") == 0
    assert command("train", "manifold", "--resume", "--out", tmp_path / "m") == 0
    file = tmp_path / "m" / manifold_config.FILE
    assert command("train", "manifold", "--config", file, "--out", tmp_path / "again") == 0
    assert command("train", "manifold", "--config", file, "--cmu", cmu, "--out", tmp_path / "other") == 0
    moved = cmu.rename(tmp_path / "moved")
    capsys.readouterr()
    assert command("train", "manifold", "--resume", "--out", tmp_path / "m") == 2
    assert (
        f"{cmu}: no such folder; {file} records it as the folder of the data; --cmu DIR replaces it"
        in capsys.readouterr().err
    )
    assert command("train", "manifold", "--resume", "--out", tmp_path / "m", "--cmu", moved) == 0
    both = {"cmu": cmu, "h36m": h36m}
    assert requested == [both, both, both, {"cmu": cmu}, both, {"cmu": moved, "h36m": h36m}]


# --- estimates of time ---


@pytest.fixture
def slow(monkeypatch):
    """Make an iteration take some seconds, by a clock that nothing else advances."""
    clock = SimpleNamespace(now=0.0, monotonic=lambda: clock.now)
    for module in (fitting, _progress):
        monkeypatch.setattr(module, "time", clock)

    def each(seconds):
        loss = trainer.TrainingRun.loss

        def slowly(member, poses, label, iteration):
            clock.now += seconds[iteration] if isinstance(seconds, list) else seconds
            return loss(member, poses, label, iteration)

        monkeypatch.setattr(trainer.TrainingRun, "loss", slowly)

    return each


@pytest.mark.usefixtures("one_thread")
def test_the_total_time_is_estimated_at_once(tmp_path, capsys, slow):
    """From the second iteration on, because the first one prepares things."""
    slow([9.0, *[2.0] * 9])
    trained(tmp_path, replace(configured(), recipe=replace(RECIPE, regime="open"), validate_every=10))
    captured = capsys.readouterr()
    first, *later = captured.err.splitlines()
    assert first == (
        "about 16 s for 10 iterations on 1 thread; --iterations N trains for fewer, all schedules in proportion"
    )
    assert later == ["training: 60.0% done, about 8 s left"]
    assert "\r" not in captured.err
    assert captured.out == ""


@pytest.mark.usefixtures("one_thread")
def test_the_total_time_of_long_iterations_is_estimated_after_the_first_one(tmp_path, capsys, slow):
    slow([60.0, *[600.0] * 9])
    trained(tmp_path, replace(configured(), recipe=replace(RECIPE, regime="open"), validate_every=10))
    assert capsys.readouterr().err.startswith("about 9 min for 10 iterations on 1 thread; ")


@pytest.mark.usefixtures("one_thread")
def test_iterations_with_a_closed_loop_take_longer(tmp_path, capsys, slow):
    """Of 6 + 4 frames: 3 x 10 + 4 before iteration 5, and 3 x 14 from then on."""
    recipe = replace(RECIPE, closed_weight=((5, 1.0),))
    assert [recipe.work(i) for i in (0, 4, 5, 9)] == [34, 34, 42, 42]
    assert replace(recipe, regime="sampling").work(9) == 30
    slow(34.0)
    trained(tmp_path, replace(configured(), recipe=recipe, validate_every=10))
    assert capsys.readouterr().err.startswith(f"about {round((4 * 34 + 5 * 42) / 60)} min for 10 iterations on ")


def test_a_short_training_prints_no_estimate(tmp_path, capsys, slow):
    slow(0.9)
    trained(tmp_path, configured())
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("seconds", "expected"), [(7.0, [5, 10]), (20.0, [2, 10]), (310.0, list(range(1, 11)))])
def test_the_first_checkpoint_is_written_within_a_minute(tmp_path, monkeypatch, slow, seconds, expected):
    slow(seconds)
    saved, save = [], checkpoint.AtomicIO.save_checkpoint

    def count(io, checkpoint, *arguments, **options):
        saved.append(checkpoint["global_step"])
        save(io, checkpoint, *arguments, **options)

    monkeypatch.setattr(checkpoint.AtomicIO, "save_checkpoint", count)
    trained(tmp_path, replace(configured(), validate_every=10, checkpoint_every=10))
    assert saved == expected


def test_a_resumed_run_prints_the_remaining_time(tmp_path, capsys, slow, signalled):
    signalled(signal.SIGTERM)
    with pytest.raises(Stopped):
        trained(tmp_path, configured())
    slow(9.0)
    trained(tmp_path, replace(configured(), validate_every=3))
    assert capsys.readouterr().err.splitlines()[0].startswith("about 54 s left of 10 iterations on ")


@pytest.mark.parametrize(
    ("later", "threads", "advice"),
    [
        (2.9, 2, None),
        (8.0, 1, "training can be stopped, and resumed later"),
        (8.0, 2, "beside them, one thread is faster: stop training, and resume it with --threads 1"),
    ],
)
def test_training_says_once_that_it_has_become_slower(tmp_path, capsys, monkeypatch, slow, later, threads, advice):
    """It compares iterations without the validation between them."""
    monkeypatch.setattr(torch, "get_num_threads", lambda: threads)
    validate = trainer.TrainingRun.validate

    def slowly(member, iteration):
        fitting.time.now += 1000 * (iteration > 6)
        return validate(member, iteration)

    monkeypatch.setattr(trainer.TrainingRun, "validate", slowly)
    slow([*[1.0] * 6, *[later] * 24])
    recipe = replace(RECIPE, iterations=30, regime="open")
    trained(tmp_path, replace(configured(), recipe=recipe, validate_every=1))
    said = [line for line in capsys.readouterr().err.splitlines() if "slower" in line]
    line = f"training is 8 times slower than at first: other programs may be using the processor; {advice}"
    assert said == ([] if advice is None else [line])


# --- without torch ---


def test_without_torch_each_command_prints_what_to_install(tmp_path):
    """Commands that do not need it work."""
    (tmp_path / config.FILE).write_text("{}", encoding="utf-8")
    code = (
        "import sys; sys.modules['torch'] = None; from npss_baselines.__main__ import main\n"
        "for line in sys.argv[1:]: print(main(line.split()), flush=True)"
    )
    lines = ["train", "train vgru-d --help", "params", f"predict {tmp_path} --out x.npz", "train manifold --quick"]
    lines += [f"evaluate {tmp_path} --synthetic", f"manifold table {tmp_path}", "evaluate zero-velocity --synthetic"]
    done = subprocess.run([sys.executable, "-c", code, *lines], capture_output=True, encoding="utf-8", check=True)
    extras = ["all"] * 4 + ["manifold", "all", "manifold"]
    assert done.stderr.splitlines() == [
        f"npss-baselines: error: this needs torch, which is not installed; {install_hint(extra, baselines=True)}"
        for extra in extras
    ]
    assert done.stdout.split("\n", 7)[:7] == ["2"] * 7
    assert done.stdout.endswith("\n0\n")


def test_errors_name_an_invalid_run(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"/nowhere: no such folder$"):
        folder.load(tmp_path / "nowhere")
    with pytest.raises(FileNotFoundError, match=rf"^{tmp_path}: no config\.json in it$"):
        folder.load(tmp_path)
    (tmp_path / config.FILE).write_text('{"paths": {"h36m": 1}}', encoding="utf-8")
    with pytest.raises(ValueError, match=r"config\.json: paths: expected an object of names and folders"):
        train_options.folder_of(SimpleNamespace(h36m=None, config=None), SOURCES["h36m"], [tmp_path])


def test_a_full_disk_leaves_no_partial_cache(tmp_path):
    text, cache = tmp_path / "walking_1.txt", tmp_path / "cache"
    text.write_text("\n".join([",".join(["0.5"] * 99)] * 40), encoding="utf-8")  # 16 kB in binary
    assert h36m._read(text, cache).shape == (40, 99)
    (kept,) = cache.iterdir()
    text.write_text("\n".join([",".join(["0"] * 99)] * 60), encoding="utf-8")
    with full_disk(20_000), pytest.raises(OSError, match=r"cannot write .*\.npy: File too large$"):
        h36m._read(text, cache)
    assert list(cache.iterdir()) == [kept]
    missing_room = pytest.raises(OSError, match=r"cannot write .*/motion-.*\.npz: File too large$")
    with full_disk(20_000), missing_room:
        prepared.cached(tmp_path / "prepared", "key", lambda: motion_set(quick=True))
    assert not list((tmp_path / "prepared").iterdir())
