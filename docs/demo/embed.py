#!/usr/bin/env python3
"""Writes docs/demo/module.js, which holds the WebAssembly of the demo as text: a page may read it without a server.

First: cargo build --profile demo --package symplint-demo --target wasm32-unknown-unknown
"""

import base64
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
BUILT = FOLDER.parents[1] / "target/wasm32-unknown-unknown/demo/symplint_demo.wasm"


def main():
    built = Path(sys.argv[1]) if len(sys.argv) > 1 else BUILT
    text = base64.b64encode(built.read_bytes()).decode()
    (FOLDER / "module.js").write_text(f'globalThis.symplintModule = "{text}";\n', encoding="utf-8")


if __name__ == "__main__":
    main()
