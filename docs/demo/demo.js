// The demo of docs/demo.md: the page asks the diagnostic in WebAssembly, and draws the loop in time.
"use strict";

(() => {
  // Names and labels.
  const SYSTEMS = {
    pendulum: "pendulum",
    "harmonic-oscillator": "harmonic oscillator",
    "henon-heiles": "Hénon–Heiles",
    "absolute-value": "potential |q|",
    kepler: "Kepler",
    toda: "Toda lattice",
    typed: "your own step",
  };
  const INTEGRATORS = ["strang", "lie-trotter", "yoshida4", "implicit-midpoint", "gauss4", "euler", "rk2", "rk4"];
  const CAPTIONS = {
    step_sizes: "Change of the loop integral against the step size",
    loop: "The loop before and after one step",
  };
  // Step sizes of a sweep: h, h/2, …
  const SIZES = 6;
  // The animation ends at states this many times as far from the origin as at its start.
  const MAX_GROWTH = 6;

  const page = (id) => document.getElementById(`demo-${id}`);

  const isTyped = () => page("system").value === "typed";

  /** Numbers with commas between them. */
  const numbers = (id) => page(id).value.split(",").map((text) => (text.trim() === "" ? NaN : Number(text)));

  /** The step that was typed, as JSON: crates/symplint-demo/src/typed.rs. */
  function typed(sizes) {
    const [q0, p0, [radius]] = ["q0", "p0", "radius"].map(numbers);
    return JSON.stringify({ step: page("code").value, q0, p0, radius, step_sizes: sizes }, null, 1);
  }

  /** What is wrong with a field; an empty text if all are numbers. */
  function mistake() {
    const wrong = ["q0", "p0", "radius"].find((id) => !numbers(id).every(Number.isFinite));
    if (!isTyped() || !wrong) return "";
    const name = { q0: "q at the centre", p0: "p at the centre", radius: "The radius" }[wrong];
    return `${name} is not a number: ${page(wrong).value || "nothing"}. Write 0.5, or 0.5, 1 for two degrees of freedom.`;
  }

  /** The question for the choices: a configuration, or a typed step. */
  function configuration() {
    const h = Number(page("step").value);
    const sizes = Array.from({ length: SIZES }, (_, k) => h / 2 ** k);
    if (isTyped()) return typed(sizes);
    const damping = page("damping").checked ? "damping = 0.05\n" : "";
    return (
      `[system]\nname = "${page("system").value}"\n\n` +
      `[integrator]\nname = "${page("integrator").value}"\n${damping}\n` +
      `[loop]\nradius = 0.5\n\n` +
      `[diagnostic]\nbudget = 200000\nstep_sizes = [${sizes.join(", ")}]\n`
    );
  }

  /** The functions of the module in docs/demo/module.js, which the build of the book makes; null without this file. */
  async function load() {
    const isThere = await new Promise((resolve) => {
      const script = document.createElement("script");
      script.src = "demo/module.js";
      script.onload = () => resolve(true);
      script.onerror = () => resolve(false);
      document.head.append(script);
    });
    return isThere ? symplintDemo.start(symplintModule) : null;
  }

  /** Draws the loops of an answer one after the other, until another answer is shown. */
  let animation = 0;
  function animate(all) {
    cancelAnimationFrame(animation);
    // An orbit that escapes would make the loop a dot.
    const reach = (frame) => Math.max(...frame.q.map(Math.abs), ...frame.p.map(Math.abs));
    const escaped = all.findIndex((frame) => !(reach(frame) <= MAX_GROWTH * reach(all[0])));
    const frames = escaped < 0 ? all : all.slice(0, escaped);
    const canvas = page("loop");
    const context = canvas.getContext("2d");
    const values = (name) => frames.flatMap((frame) => frame[name]);
    const range = (numbers) => numbers.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
    const [[left, right], [bottom, top]] = [range(values("q")), range(values("p"))];
    const margin = 12;
    const scale = Math.min((canvas.width - 2 * margin) / (right - left || 1), (canvas.height - 2 * margin) / (top - bottom || 1));
    const x = (q) => canvas.width / 2 + scale * (q - (left + right) / 2);
    const y = (p) => canvas.height / 2 - scale * (p - (bottom + top) / 2);
    const dots = (frame, color) => {
      context.fillStyle = color;
      frame.q.forEach((q, k) => context.fillRect(x(q) - 1.5, y(frame.p[k]) - 1.5, 3, 3));
    };
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const draw = (count) => {
      context.clearRect(0, 0, canvas.width, canvas.height);
      dots(frames[0], "#8b949e");
      dots(frames[count], "#d55e00");
      page("steps").textContent = count === 1 ? "1 step" : `${count} steps`;
    };
    if (still) {
      draw(Math.min(1, frames.length - 1));
      return;
    }
    let start;
    const next = (now) => {
      start ??= now;
      // Eight steps in a second, and a pause at the end.
      const count = Math.floor(((now - start) / 125) % (frames.length + 8));
      draw(Math.min(count, frames.length - 1));
      animation = requestAnimationFrame(next);
    };
    animation = requestAnimationFrame(next);
  }

  function show(answer) {
    page("error").textContent = answer.error ?? "";
    page("answer").hidden = Boolean(answer.error);
    if (answer.error) return;
    page("answer").dataset.kind = answer.kind;
    page("text").textContent = answer.text;
    const named = ({ name, svg }) => svg.replace("<svg ", `<svg role="img" aria-label="${CAPTIONS[name] ?? "A figure"}" `);
    page("figures").innerHTML = answer.figures.map((figure) => `<figure>${named(figure)}</figure>`).join("");
    animate(answer.frames);
    // Parts that continue to the right are marked.
    dispatchEvent(new Event("resize"));
  }

  async function start() {
    const options = (entries) => entries.map(([value, label]) => `<option value="${value}">${label}</option>`).join("");
    page("system").innerHTML = options(Object.entries(SYSTEMS));
    page("integrator").innerHTML = options(INTEGRATORS.map((name) => [name, name]));
    page("running").textContent = "The diagnostic loads (8 MB) …";
    const exports = await load();
    page("running").textContent = "";
    if (!exports) {
      page("error").textContent = "This copy of the book has no demo: it was built without WebAssembly. The page for developers describes the build.";
      return;
    }
    page("form").hidden = false;
    const run = () => {
      for (const part of page("form").querySelectorAll("[data-of]")) part.hidden = (part.dataset.of === "typed") !== isTyped();
      if (mistake()) {
        show({ error: mistake() });
        return;
      }
      page("configuration").textContent = configuration();
      page("running").textContent = "The diagnosis runs …";
      // After the browser has drawn this line.
      setTimeout(() => {
        show(symplintDemo.ask(exports, configuration()));
        page("running").textContent = "";
      }, 20);
    };
    page("form").addEventListener("change", run);
    page("form").addEventListener("submit", (event) => {
      event.preventDefault();
      run();
    });
    run();
  }

  start();
})();
