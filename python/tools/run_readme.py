"""Runs the Python code of Markdown files as a reader does who pastes it: each file from its beginning, block by block.

``README.md#Python`` is the section of that heading alone. Blocks of other languages are left out.
"""

import re
import sys
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
        for number, block in enumerate(blocks, 1):
            exec(compile(block, f"{name}, block {number}", "exec"), namespace)


if __name__ == "__main__":
    main()
