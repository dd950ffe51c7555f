"""Records of in-betweening, their table, and published rows beside them."""

from dataclasses import replace

import numpy as np
import pytest

import npss
from npss.inbetweening import Global, lafan1, measure, table

MINE = replace(lafan1, name="mine", windows=None, zero_velocity={})
ONES = {"mean": np.ones(66), "std": np.ones(66)}


def motion(n, seed=0):
    """Return gt and pred, two windows of 22 joints."""
    rng = np.random.default_rng(seed)
    angle = rng.normal(0, 0.05, (2, n, 22)).cumsum(axis=1) + rng.uniform(-1, 1, (2, 1, 22))
    quaternions = np.stack([np.cos(angle), np.sin(angle), 0 * angle, 0 * angle], axis=-1)
    gt = Global(quaternions, rng.normal(size=(2, n, 22, 3)))
    return gt, Global(np.repeat(quaternions[:, :1], n, axis=1), np.repeat(gt.positions[:, :1], n, axis=1))


def record(n, **options):
    return measure(*motion(n), **{"model": "m", "protocol": MINE, **ONES, **options})


def test_record():
    one = record(30, sequences=True, groups=["a", "b"], extra={"data": "mine"})
    assert one["model"] == "m"
    assert one["action"] == "in-betweening, 30 frames"
    stated = "frames:30|fps:30|protocol:mine|unwrap:off"
    assert one["signatures"] == {
        "released": "npss|version:1|convention:released|representation:global-quaternions|"
        f"{stated}|data:mine|quaternions:continuous",
        "L2Q": f"l2q|version:1|representation:global-quaternions|{stated}|data:mine|hemisphere:anchored|norm:pose|"
        "quaternions:continuous",
        "L2P": f"l2p|version:1|representation:global-positions|{stated}|data:mine|norm:pose|positions:standardised",
    }
    for name, values in one["sequences"]["metrics"].items():
        assert np.mean(values) == pytest.approx(one["metrics"][name])
    board = npss.leaderboard(
        [one, record(30, model="other", sequences=True, groups=["a", "b"], extra={"data": "mine"})]
    )
    assert set(board.columns.get_level_values(1)) == {"NPSS released", "L2Q", "L2P"}


def test_signatures_state_variants():
    one = record(5, hemisphere="given", norm="joint", unit="cm", mean=None, std=None)
    assert "quaternions" not in npss.parse_signature(one["signatures"]["released"])
    assert one["signatures"]["L2Q"].endswith("|hemisphere:given|norm:joint")
    assert one["signatures"]["L2P"].endswith("|norm:joint|positions:cm")
    assert npss.parse_signature(record(5, hemisphere="nearest")["signatures"]["L2Q"])["hemisphere"] == "nearest"


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"fps": 60}, ValueError, "fps: mine has 30 frames per second, got 60"),
        ({"protocol": "lafan1"}, TypeError, "protocol: expected an InBetweening such as lafan1, got 'lafan1'"),
        ({"protocol": replace(MINE, joints=21)}, ValueError, "gt: mine has 21 joints, got 22"),
        ({"std": None}, ValueError, "std: expected both mean and std"),
    ],
)
def test_measure_refuses(options, error, message):
    with pytest.raises(error, match=message):
        record(30, **options)


def test_measure_refuses_key_frames():
    with pytest.raises(ValueError, match="gt: mine has transitions of 5, 15, 30, 45 frames, got 32"):
        record(32)
    gt, pred = motion(5)
    with pytest.raises(ValueError, match=r"gt: quaternions and positions differ in .*: \(2, 5, 22\) and \(2, 4, 22\)"):
        measure(*(Global(one.quaternions, one.positions[:, 1:]) for one in (gt, pred)), **ONES)
    unequal = [
        Global([q, q[:-1]], [p, p[:-1]]) for q, p in ((one.quaternions[0], one.positions[0]) for one in (gt, pred))
    ]
    with pytest.raises(ValueError, match="gt: expected sequences of one length, got 4, 5 frames; measure each length"):
        measure(*unequal, **ONES)
    with pytest.raises(TypeError, match=r"pred: expected Global\(quaternions, positions\), got ndarray"):
        measure(gt, pred.quaternions, **ONES)
    with pytest.raises(TypeError, match=r"gt: no positions; npss\.score\(.*\) and l2q take quaternions alone"):
        measure(Global(gt.quaternions, None), pred, **ONES)


def test_table_of_published_rows():
    text = table(npss.published.records(protocol="lafan1"))
    head, _, *rows = text.split("\n\n")[0].splitlines()
    lengths = ["5", "15", "30", "45"]
    assert head.split() == ["model", "L2Q", *lengths, "L2P", *lengths, "NPSS", *lengths]
    cells = {row.partition(" (published)")[0]: row.partition(" (published)")[2].split() for row in rows}
    assert cells["two-stage transformer"] == (
        ["0.0994", "0.2839", "0.5446", "0.8727", "0.1049", "0.3943", "0.8948", "1.6777"]
        + ["0.0011", "0.0188", "0.1124", "0.3217"]
    )
    assert cells["Delta-interpolator"][-3:] == ["0.0014", "0.0217", "0.1217"]
    assert cells["zero-velocity"][:8] == ["0.56", "1.10", "1.51", "1.81", "1.52", "3.69", "6.60", "9.33"]
    assert list(cells) == [
        "zero-velocity",
        "interpolation",
        "Delta-interpolator",
        "two-stage transformer",
        "context transformer",
    ]
    assert "frames:5 15 30 45|" in text
    assert "- context transformer (published): Qin et al. 2022, the authors' repository" in text


def test_own_rows_beside_published_ones():
    own = [record(n) | {"signatures": as_lafan1(record(n))} for n in (5, 45)]
    text = table(own, published=True, markdown=True)
    mine = next(line for line in text.splitlines() if line.startswith("| m "))
    cells = [cell.strip() for cell in mine.split("|")[2:-1]]
    assert [bool(cell) for cell in cells] == [True, False, False, True] * 3
    assert cells[0] == f"{own[0]['metrics']['L2Q']:.4f}"
    assert "(published)" in text


def as_lafan1(one):
    """Return the signatures of a record as if its windows were the benchmark's."""
    return {name: text.replace("protocol:mine", "protocol:lafan1") for name, text in one["signatures"].items()}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, "published: 'm' differs in L2Q: protocol must be lafan1, not mine"),
        ({"norm": "joint"}, "published: 'm' differs in L2Q: norm must be pose, not joint"),
        ({"hemisphere": "given"}, "published: 'm' differs in L2Q: hemisphere must be anchored, not given"),
        (
            {"mean": None, "std": None, "unit": "m"},
            "published: 'm' differs in L2P: positions must be standardised, not m",
        ),
        ({"extra": {"a": 1}}, "published: 'm' differs in L2Q: a must not be stated, but is 1"),
    ],
)
def test_published_says_in_one_line_what_differs(change, message):
    one = record(30, **change)
    if change:
        one["signatures"] = as_lafan1(one)
    with pytest.raises(ValueError, match=f"^{message}$"):
        table([one], published=True)


def test_columns_have_one_meaning():
    with pytest.raises(ValueError, match="records: 'n' and 'm' differ in L2Q: norm must be pose, not rmse"):
        table([record(5), record(5, model="n", norm="rmse")])
    with pytest.raises(ValueError, match="records: duplicate L2Q of 'm' at 5 frames"):
        table([record(5), record(5)])
    with pytest.raises(ValueError, match="records: expected text as 'model' in each, got None"):
        table([record(5, model=None)])
    with pytest.raises(ValueError, match="records: expected at least one"):
        table([])
    with pytest.raises(ValueError, match="records: 'm' has NPSS without a signature"):
        table([{"model": "m", "npss": {"released": 1.0}}])


def test_standard_deviations_are_compared():
    first, other = record(30), record(30, model="other", std=9 * np.ones(66))
    assert first["std"] == [1.0] * 66
    assert "std" not in record(30, mean=None, std=None, unit="m")
    with pytest.raises(ValueError, match=r"'other' and 'm' differ in L2P: .* other standard deviations"):
        table([first, other])
    table([first, record(30, model="other", std=(1 + 1e-7) * np.ones(66))])


@pytest.mark.parametrize(
    ("metrics", "message"),
    [
        ("x", "records: expected an object as 'metrics' of 'm'"),
        ({"L2Q": float("nan")}, "records: expected a finite L2Q"),
    ],
)
def test_damaged_records_are_refused(metrics, message):
    with pytest.raises(ValueError, match=message):
        table([{**record(30), "metrics": metrics}])


def test_what_is_no_record_is_refused():
    with pytest.raises(TypeError, match=r"^records: expected dicts, got 3"):
        table([3])
    record = {"model": "m", "npss": {"released": 1.0}, "signatures": {"released": "npss|version:1|convention:released"}}
    with pytest.raises(ValueError, match="its signature does not state frames"):
        table([record])
