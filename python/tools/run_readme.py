"""Runs the Python code of Markdown files as a reader does who pastes it: each file from its beginning, block by block.

``README.md#Python`` is the section of that heading alone. Blocks of other languages are left out. What the code writes into the
working folder goes to a temporary one.
"""

import os
import re
import sys
import tempfile
from pathlib import Path


def main() -> None:
    for name in sys.argv[1:]:
        path, _, heading = name.partition("#")
        text = Path(path).read_text(encoding="utf-8")
        if heading:
            text = text.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
        blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
        if not blocks:
            sys.exit(f"{name} has no Python code")
        namespace: dict[str, object] = {"__name__": "__main__"}
        here = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            for number, block in enumerate(blocks, 1):
                exec(compile(block, f"{name}, block {number}", "exec"), namespace)
            os.chdir(here)


if __name__ == "__main__":
    main()
