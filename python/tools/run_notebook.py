"""Runs the code of notebooks from beginning to end, without Jupyter: ``run_notebook.py NOTEBOOK [FOLDER]``.

Figures are made by matplotlib without a display, and written to the folder, if one is given. Stored outputs are refused: they would
make files large, and could be those of other code.
"""

import json
import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt


def main(name: str, folder: str | None = None) -> None:
    notebook = json.loads(Path(name).read_text(encoding="utf-8"))
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    if not cells or any(cell["outputs"] or cell["execution_count"] for cell in cells):
        sys.exit(f"{name} has no code, or stored outputs: clear them")
    namespace: dict[str, object] = {"__name__": "__main__"}
    for number, cell in enumerate(cells, 1):
        exec(compile("".join(cell["source"]), f"{name}, code cell {number}", "exec"), namespace)
    for number in plt.get_fignums() if folder else ():
        plt.figure(number).savefig(Path(folder, f"{Path(name).stem}-{number}.png"), dpi=100)


if __name__ == "__main__":
    main(*sys.argv[1:])
