// Compares the demo with the program: node docs/demo/compare.mjs target/release/symplint
//
// Both diagnose the same configurations, and must print the same text and draw the same figures, except for rounding errors: Fourier
// transforms add in another order without the vector instructions of the processor.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import "./ask.js";

const program = process.argv[2];
const module = readFileSync(new URL("module.js", import.meta.url), "utf8").match(/"(.*)"/)[1];
const exports = await symplintDemo.start(module);

/** A text without rounding errors, and without the spaces that align them. */
function withoutRounding(text) {
  return text
    .replace(/\b\d(\.\d+)?e-1[2-9]\b/g, "ε")
    .replace(/(?<=\s)0(?=\s)/g, "ε")
    .replace(/\b1\d(\.\d+)? digits/g, "all digits")
    .replace(/\s+/g, " ")
    .trim();
}

/** The words and numbers in a figure. */
const labels = (svg) => [...svg.matchAll(/>([^<\n]+)<\/text>/g)].map(([, label]) => label).join(" | ");

let failed = 0;
let passed = 0;
for (const [system, integrator, more] of [
  ["pendulum", "strang", ""],
  ["pendulum", "rk2", ""],
  ["pendulum", "strang", "damping = 0.05"],
  ["absolute-value", "strang", ""],
  ["henon-heiles", "rk4", ""],
  ["toda", "gauss4", ""],
]) {
  const text = `[system]\nname = "${system}"\n[integrator]\nname = "${integrator}"\n${more}\n[loop]\nradius = 0.5\n[diagnostic]\nbudget = 200000\nstep_sizes = [0.5, 0.25, 0.125, 0.0625]\n`;
  const folder = mkdtempSync(join(tmpdir(), "symplint-demo-"));
  try {
    const file = join(folder, "run.toml");
    const out = join(folder, "run");
    writeFileSync(file, text);
    const native = spawnSync(program, ["check", file, "--out", out], { encoding: "utf8", env: { ...process.env, COLUMNS: "80" } });
    const { text: said = "", figures = [], kind, error } = symplintDemo.ask(exports, text);
    const differences = [];
    if (error) differences.push(error);
    // The program adds the name of the folder.
    const printed = native.stdout.slice(0, native.stdout.lastIndexOf("  Written to"));
    if (withoutRounding(printed) !== withoutRounding(said)) differences.push(`text:\n${printed}\n${said}`);
    for (const { name, svg } of figures) {
      const drawn = readFileSync(join(out, "figures", `${name}.svg`), "utf8");
      // The other figure of a symplectic map shows rounding errors.
      const isSame = name === "loop" ? drawn === svg : kind === "symplectic" || labels(drawn) === labels(svg);
      if (!isSame) differences.push(`figure ${name}: ${labels(drawn)}\n${labels(svg)}`);
    }
    if (differences.length === 0 && figures.length > 0) passed += 1;
    else {
      failed += 1;
      console.log(`${system}, ${integrator}: ${differences.join("\n")}`);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
}
// A typed step has the verdict of the same method in the program; the explicit Euler method is not symplectic.
const SIZES = [0.5, 0.25, 0.125, 0.0625];
for (const [name, step, integrator] of [
  ["leapfrog", "p = p - h/2*sin(q)\nq = q + h*p\np = p - h/2*sin(q)", 'name = "strang"\nvariant = "momentum-first"'],
  ["explicit Euler", "F = -sin(q)\nq = q + h*p\np = p + h*F", 'name = "euler"'],
]) {
  const typed = symplintDemo.ask(exports, JSON.stringify({ step, q0: [1], p0: [0.5], radius: 0.5, step_sizes: SIZES }));
  const text = `[system]\nname = "pendulum"\nq0 = 1.0\np0 = 0.5\n[integrator]\n${integrator}\n[loop]\nradius = 0.5\n[diagnostic]\nbudget = 200000\nstep_sizes = [${SIZES}]\n`;
  const native = spawnSync(program, ["check", "-", "--json"], { encoding: "utf8", input: text });
  const { verdict } = native.stdout ? JSON.parse(native.stdout) : { verdict: { kind: native.stderr } };
  if (typed.kind === verdict.kind && (verdict.kind === "symplectic") === (name === "leapfrog")) passed += 1;
  else {
    failed += 1;
    console.log(`typed ${name}: ${typed.kind ?? typed.error} and ${verdict.kind}`);
  }
}
const misprint = symplintDemo.ask(exports, JSON.stringify({ step: "q = q + h*", q0: [1], p0: [0.5], radius: 0.5, step_sizes: SIZES }));
if (misprint.error?.startsWith("line 1, column 11: ")) passed += 1;
else {
  failed += 1;
  console.log(`misprint: ${JSON.stringify(misprint)}`);
}
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed === 0 && passed > 0 ? 0 : 1);
