"use strict";
// figures that can be enlarged: their data is the CSV file, packed into the page; without this script the drawing stays as it is
(() => {
  if (!("DecompressionStream" in window) || typeof uPlot === "undefined") return;
  const texts = new Map();
  const text = (id) => {
    if (!texts.has(id)) {
      const bytes = Uint8Array.from(atob(document.getElementById(id).textContent.trim()), (c) => c.charCodeAt(0));
      texts.set(id, new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text());
    }
    return texts.get(id);
  };
  const cells = (line) => [...line.matchAll(/("(?:[^"]|"")*"|[^,]*)(,|$)/g)].map((m) => m[1].replace(/^"|"$/g, "").replaceAll('""', '"'));
  const number = (word) => (word === "" || word === undefined ? null : Number(word));

  // panel -> curves: [{name, look, x, y}]
  const panels = (csv) => {
    const [head, ...lines] = csv.trim().split("\n");
    const found = new Map();
    let last = null;
    for (const line of lines) {
      const [panel, name, look, x, y] = cells(line);
      if (!found.has(panel)) found.set(panel, []);
      if (!last || last.panel !== panel || last.name !== name) found.get(panel).push((last = { panel, name, look, x: [], y: [] }));
      last.x.push(number(x));
      last.y.push(number(y));
    }
    return found;
  };
  const DASHES = { dashed: [6, 3], dotted: [2, 2], "dash-dotted": [6, 2, 2, 2] };
  const shade = (color) => getComputedStyle(document.documentElement).getPropertyValue("--c" + color.slice(1)).trim() || color;

  const draw = (curve) => (u) => {
    const ctx = u.ctx, points = curve.look.startsWith("points"), r = 2.2 * devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = shade(curve.color);
    ctx.lineWidth = 1.4 * devicePixelRatio;
    ctx.setLineDash((DASHES[curve.look.split(" ")[0]] || []).map((d) => d * devicePixelRatio));
    ctx.beginPath();
    let pen = false, before = 0;
    for (let k = 0; k < curve.x.length; k++) {
      if (curve.x[k] === null || curve.y[k] === null) { pen = false; continue; }
      const x = u.valToPos(curve.x[k], "x", true), y = u.valToPos(curve.y[k], "y", true);
      if (points) ctx.rect(x - r, y - r, 2 * r, 2 * r);
      else if (pen) {
        if (curve.look.includes("steps-pre")) ctx.lineTo(before, y);
        ctx.lineTo(x, y);
      }
      else ctx.moveTo(x, y);
      pen = true;
      before = x;
    }
    if (points) ctx.fill();
    else ctx.stroke();
    ctx.restore();
    return null;
  };

  // a plot of one panel in the element `place`; returns it with its ways to move
  const plot = (place, facts, curves, told, height) => {
    const ink = getComputedStyle(document.body).color;
    const home = { x: facts.limits[0], y: facts.limits[1] };
    const distr = facts.scales.map((scale) => (scale === "log" ? 3 : 1));
    const axis = (label) => ({ label, stroke: ink, grid: { stroke: "#8885" }, ticks: { stroke: "#8885" } });
    const shown = curves.filter((curve) => !/^(area|cells|text)/.test(curve.look));
    const nearest = (u) => {
      let best = null, least = 30 * 30;
      for (const curve of shown) for (let k = 0; k < curve.x.length; k++) {
        if (curve.x[k] === null || curve.y[k] === null) continue;
        const d = (u.valToPos(curve.x[k], "x") - u.cursor.left) ** 2 + (u.valToPos(curve.y[k], "y") - u.cursor.top) ** 2;
        if (d < least) { least = d; best = { curve, x: curve.x[k], y: curve.y[k] }; }
      }
      return best;
    };
    const u = new uPlot({
      mode: 2, width: place.clientWidth, height, legend: { show: false },
      cursor: { points: { show: false }, dataIdx: () => null, drag: { x: true, y: true, uni: 20 }, bind: { dblclick: () => () => { reset(); return null; } } },
      scales: { x: { time: false, distr: distr[0], auto: false, min: home.x[0], max: home.x[1] }, y: { distr: distr[1], auto: false, min: home.y[0], max: home.y[1] } },
      axes: [axis(facts.x_label), axis(facts.y_label)],
      series: [{}, ...shown.map((curve) => ({ label: curve.name, stroke: curve.color, paths: draw(curve), facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }] }))],
      hooks: { setCursor: [(at) => told(at.cursor.left >= 0 ? nearest(at) : null)] },
    }, [null, ...shown.map((curve) => [curve.x, curve.y])], place);
    const along = { x: distr[0] === 3, y: distr[1] === 3 };
    const set = (key, low, high) => u.setScale(key, along[key] ? { min: 10 ** low, max: 10 ** high } : { min: low, max: high });
    const ends = (key) => [u.scales[key].min, u.scales[key].max].map((v) => (along[key] ? Math.log10(v) : v));
    const zoom = (factor, at = { x: 0.5, y: 0.5 }) => u.batch(() => {
      for (const key of ["x", "y"]) {
        const [low, high] = ends(key), middle = low + at[key] * (high - low);
        set(key, middle + factor * (low - middle), middle + factor * (high - middle));
      }
    });
    const pan = (dx, dy) => u.batch(() => {
      for (const [key, share] of [["x", dx], ["y", dy]]) {
        const [low, high] = ends(key);
        if (share) set(key, low + share * (high - low), high + share * (high - low));
      }
    });
    const reset = () => u.batch(() => { for (const key of ["x", "y"]) u.setScale(key, { min: home[key][0], max: home[key][1] }); });
    u.over.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = u.over.getBoundingClientRect();
      zoom(event.deltaY > 0 ? 1.25 : 0.8, { x: (event.clientX - box.left) / box.width, y: 1 - (event.clientY - box.top) / box.height });
    }, { passive: false });
    return { u, zoom, pan, reset };
  };

  const KEYS = { "+": (p) => p.zoom(0.6), "=": (p) => p.zoom(0.6), "-": (p) => p.zoom(1 / 0.6), 0: (p) => p.reset() };
  const ARROWS = { ArrowLeft: [-0.2, 0], ArrowRight: [0.2, 0], ArrowUp: [0, 0.2], ArrowDown: [0, -0.2] };

  const enlarge = async (button) => {
    const store = document.getElementById(button.dataset.curves), facts = JSON.parse(store.dataset.panels);
    const found = panels(await text(store.id)), beside = store.dataset.beside && document.getElementById(store.dataset.beside);
    const motions = beside ? [...panels(await text(beside.id)).values()].flat() : [];
    const dialog = document.createElement("dialog");
    dialog.className = "enlarged";
    dialog.setAttribute("aria-label", button.dataset.title);
    dialog.innerHTML = `<form method="dialog"><label>panel <select></select></label> <span class="keys">drag, wheel, + − 0, shift and arrows</span> <button>Close</button></form><div class="plot" tabindex="0" role="application"></div><output aria-live="polite"></output><div class="motion"></div>`;
    const [select, place, output, motion] = ["select", ".plot", "output", ".motion"].map((name) => dialog.querySelector(name));
    place.setAttribute("aria-label", button.dataset.title);
    facts.forEach((panel, k) => select.append(new Option(panel.name, k)));
    document.body.append(dialog);
    let shown = null, small = null, last = null;
    const told = (at) => {
      if (!at) return;
      output.textContent = `${at.curve.name}: ${+at.x.toPrecision(7)}, ${+at.y.toPrecision(7)}`;
      if (!motions.length) return;
      // the motion whose place on the branch, written in its name, is nearest
      const far = (one) => { const [T, r] = one.name.match(/[-−]?\d+(\.\d+)?/g).map((word) => +word.replace("−", "-")); return Math.hypot((T - at.y) / 10, (r - at.x) / 0.08); };
      const best = motions.reduce((one, other) => (far(other) < far(one) ? other : one));
      if (best === last) return;
      last = best;
      small?.u.destroy();
      motion.replaceChildren(Object.assign(document.createElement("p"), { textContent: best.name }));
      const range = (values) => [Math.min(...values.filter((v) => v !== null)), Math.max(...values.filter((v) => v !== null))];
      const own = JSON.parse(beside.dataset.panels)[0];
      const least = range(best.y)[0], y = best.y.map((v) => (v === null ? v : v - least));
      const facts = { ...own, y_label: "above its least", limits: [range(best.x), range(y)] };
      small = plot(motion, facts, [{ ...best, y, color: "#111111", look: "solid" }], () => {}, 160);
    };
    const show = () => {
      shown?.u.destroy();
      const panel = facts[+select.value];
      const moved = (values, by) => values.map((v) => (v === null ? v : v + by));
      const curves = (found.get(panel.name) || []).map((curve, k) => {
        const [right, up] = panel.shifts[k];
        return { ...curve, x: moved(curve.x, right), y: moved(curve.y, up), color: panel.colors[k] || "#777777" };
      });
      shown = plot(place, panel, curves, told, Math.round(innerHeight * (motions.length ? 0.5 : 0.72)));
    };
    select.addEventListener("change", show);
    dialog.addEventListener("keydown", (event) => {
      const act = KEYS[event.key], way = event.shiftKey && ARROWS[event.key];
      if (event.target === select || (!act && !way)) return;
      event.preventDefault();
      if (act) act(shown);
      else shown.pan(...way);
    });
    dialog.addEventListener("close", () => { shown.u.destroy(); dialog.remove(); button.focus(); });
    dialog.showModal();
    show();
    place.focus();
    dialog.shown = () => shown;
  };

  for (const button of document.querySelectorAll("button.enlarge")) {
    button.hidden = false;
    button.addEventListener("click", () => enlarge(button));
  }
  // the packed data is the file: a page that was sent alone still has it
  for (const link of document.querySelectorAll("a[data-packed]")) link.addEventListener("click", async (event) => {
    event.preventDefault();
    const address = URL.createObjectURL(new Blob([await text(link.dataset.packed)], { type: "text/csv" }));
    Object.assign(document.createElement("a"), { href: address, download: link.getAttribute("download") }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  });
})();
