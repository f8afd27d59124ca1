// Questions to the diagnostic in WebAssembly (crates/symplint-demo/src/memory.rs), for demo.js and compare.mjs.
"use strict";

globalThis.symplintDemo = {
  /** The functions of the module, from its bytes in base64. */
  async start(base64) {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const module = await WebAssembly.compile(bytes);
    // A crate that reads archives names functions of wasm-bindgen. The diagnosis of a configuration calls none of them.
    const imports = {};
    for (const { module: source, name } of WebAssembly.Module.imports(module)) {
      imports[source] ??= {};
      imports[source][name] = () => {
        throw new Error(`${name} is not available`);
      };
    }
    return (await WebAssembly.instantiate(module, imports)).exports;
  },

  /** The answer to a configuration. */
  ask({ memory, symplint_allocate, symplint_answer, symplint_free }, configuration) {
    const bytes = new TextEncoder().encode(configuration);
    const at = symplint_allocate(bytes.length);
    new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
    const answer = symplint_answer(at, bytes.length);
    symplint_free(at, bytes.length);
    const length = new DataView(memory.buffer).getUint32(answer, true);
    const json = new TextDecoder().decode(new Uint8Array(memory.buffer, answer + 4, length));
    symplint_free(answer, length + 4);
    return JSON.parse(json);
  },
};
