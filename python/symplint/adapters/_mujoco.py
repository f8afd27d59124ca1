"""Integrators of MuJoCo."""

from __future__ import annotations

import copy
import importlib
from typing import Any

import numpy as np

from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["mujoco"]


def mujoco(model: Any, data: Any) -> AdaptedStep:
    """The integrator of a model of MuJoCo.

    Parameters
    ----------
    model : mujoco.MjModel
        A model whose joints are hinges and slides. The integrator and a typical step are those of ``model.opt``. It is not changed.
    data : mujoco.MjData
        The centre of the loops, with its controls and applied forces. It is not changed.

    Returns
    -------
    AdaptedStep
        One step of size h. States are ``qpos`` and the canonical momenta M(q) ``qvel``, with the mass matrix M(q) of MuJoCo.

    Raises
    ------
    InputError
        If a joint is a ball or free, or actuators have states.

    Notes
    -----
    Set up once: a copy of the model and of the data. For each state: the data are copied into the working data, and ``qpos`` and ``qvel``
    are set, the latter by a solution with M(q). Warm starts of the solver begin as in `data`.

    Examples
    --------
    >>> import mujoco, symplint
    >>> model = mujoco.MjModel.from_xml_string('''<mujoco><option timestep="0.01"/><worldbody><body>
    ...     <joint type="slide" axis="0 0 1" stiffness="40"/><geom size="0.1"/></body></worldbody></mujoco>''')
    >>> data = mujoco.MjData(model)
    >>> symplint.check(symplint.adapters.mujoco(model, data), radius=0.1, budget=2000, loops=2).kind
    'symplectic'
    """
    library = importlib.import_module("mujoco")
    if not isinstance(model, library.MjModel) or not isinstance(data, library.MjData):
        kinds = f"{type(model).__name__} and {type(data).__name__}"
        raise InputError(f"model and data are objects of the types {kinds}; give a mujoco.MjModel and its mujoco.MjData")
    if model.nq != model.nv or not set(model.jnt_type) <= {int(library.mjtJoint.mjJNT_HINGE), int(library.mjtJoint.mjJNT_SLIDE)}:
        raise InputError("a joint is a ball or free, and its quaternion has no canonical momentum; use hinges and slides")
    if model.na:
        raise InputError(f"the actuators have {model.na} states, which are not positions or momenta; use actuators without dynamics")
    model = copy.copy(model)
    beginning, work = copy.copy(data), copy.copy(data)

    def momentum() -> Any:
        # Computes the mass matrix of the state.
        library.mj_forward(model, work)
        found = np.empty(model.nv)
        library.mj_mulM(model, work, found, work.qvel)
        return found

    def step(q: Any, p: Any, h: float) -> tuple[Any, Any]:
        model.opt.timestep = h
        library.mj_copyData(work, model, beginning)
        work.qpos[:], work.qvel[:] = q, 0.0
        library.mj_forward(model, work)
        velocity = np.empty((1, model.nv))
        library.mj_solveM(model, work, velocity, np.ascontiguousarray(p)[None, :])
        work.qvel[:], work.qacc_warmstart[:] = velocity[0], beginning.qacc_warmstart
        library.mj_step(model, work)
        return work.qpos.copy(), momentum()

    name = library.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_")
    return AdaptedStep(step, f"MuJoCo {name}", data.qpos, momentum(), typical_step=model.opt.timestep)
