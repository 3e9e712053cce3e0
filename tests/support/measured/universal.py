"""Universal files with time signals, written by pyuff."""

import numpy as np
import pytest

VELOCITY, FORCE = 11, 13  # types of ordinate data


def write_uff(path, signals, rate, function=1):
    """Write signals given as (node, type, unit, samples), all in direction +z."""
    pyuff = pytest.importorskip("pyuff")
    file = pyuff.UFF(str(path))
    for node, kind, unit, samples in signals:
        dataset = pyuff.prepare_58(
            binary=0,
            func_type=function,
            rsp_node=node,
            rsp_dir=3,
            ref_node=1,
            ref_dir=3,
            ord_data_type=4,
            num_pts=len(samples),
            abscissa_spacing=1,
            abscissa_min=0.0,
            abscissa_inc=1.0 / rate,
            abscissa_spec_data_type=17,
            ordinate_spec_data_type=kind,
            ordinate_axis_units_lab=unit,
            data=samples,
            x=np.arange(len(samples)) / rate,
            return_full_dict=True,
        )
        for key, value in dataset.items():  # pyuff writes no None
            if value is None:
                is_text = key.startswith("id") or key.endswith(("_lab", "_name"))
                dataset[key] = "" if is_text else 0
        file.write_sets(dataset, "add")
