"""Values that every function refuses as motion."""

import numpy as np

SHAPE = (2, 4, 3)


class NeedsDetaching:
    """Like a tensor that requires gradients."""

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("Can't call numpy() on Tensor that requires grad.")


REFUSED_TYPES = {
    "bool": np.ones(SHAPE, bool),
    "complex": np.ones(SHAPE, complex),
    "object": np.ones(SHAPE, object),
    "string": np.full(SHAPE, "1"),
    "bytes": np.full(SHAPE, b"1"),
    "string dtype": np.full(SHAPE, "1", dtype=np.dtypes.StringDType()),
    "date": np.zeros(SHAPE, "datetime64[s]"),
    "time difference": np.zeros(SHAPE, "timedelta64[s]"),
    "record": np.zeros(SHAPE, [("x", float)]),
    "masked": np.ma.masked_array(np.ones(SHAPE), np.zeros(SHAPE)),
    "tensor that needs detaching": NeedsDetaching(),
    "None": None,
    "text": "motion",
    "dict": {"a": 1},
}

REFUSED_VALUES = {
    "one axis": (np.ones(4), r"expected shape \(N, T, D\) or \(T, D\)"),
    "no axis": (np.float64(1), r"expected shape"),
    "matrices of one joint, or positions of three": (np.ones((2, 4, 3, 3)), r"shape \(2, 4, 3, 3\) may be"),
    "batches of sequences": (np.ones((2, 2, 4, 17)), r"shape \(2, 2, 4, 17\) would be joints of 17 numbers each"),
    "five axes": (np.ones((1, 2, 3, 4, 5)), r"expected shape"),
    "matrices without their representation": (np.ones((1, 4, 2, 3, 3)), r"expected .*pass representation='matrix'"),
    "no joints": (np.ones((2, 4, 0, 3)), r"no features in an array of shape \(2, 4, 0, 3\)"),
    "no sequences": (np.ones((0, 4, 3)), r"no sequences in an array of shape \(0, 4, 3\)"),
    "no frames": (np.ones((2, 0, 3)), r"no frames in an array of shape \(2, 0, 3\)"),
    "no features": (np.ones((2, 4, 0)), r"no features in an array of shape \(2, 4, 0\)"),
    "no frames of one": (np.ones((0, 3)), r"no frames in an array of shape \(0, 3\)"),
    "ragged": ([[1.0, 2.0], [3.0]], r"not a regular array"),
}
