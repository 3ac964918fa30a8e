"use strict";
(() => {
  const element = (id) => document.getElementById(id);
  const { speeds, pairs } = JSON.parse(element("curves").textContent);
  const [picker, slider, answer, picture] = ["pair", "speed", "answer", "curve"].map(element);
  const fastest = speeds[speeds.length - 1];
  const margin = { left: 48, right: 12, top: 10, bottom: 44 };
  const height = 340;
  slider.max = speeds.length - 1;

  // a step of 1, 2 or 5 in its leading digit, so that an axis has about six
  const step = (length) => {
    const decade = 10 ** Math.floor(Math.log10(length / 5));
    return [1, 2, 5, 10].map((digit) => digit * decade).find((own) => length / own <= 7);
  };
  const decimals = (own) => Math.max(0, -Math.floor(Math.log10(own) + 1e-9));

  const draw = (pair, place) => {
    const width = Math.max(300, Math.min(760, picture.parentElement.clientWidth));
    const top = Math.max(1, ...pair.restitution, ...pair.rebounds.map(([, e]) => e));
    const x = (v) => margin.left + (v / fastest) * (width - margin.left - margin.right);
    const y = (e) => height - margin.bottom - (e / top) * (height - margin.top - margin.bottom);
    const add = (name, attributes, text) => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", name);
      Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
      if (text !== undefined) made.textContent = text;
      picture.append(made);
    };
    const line = (ends, kind) =>
      add("polyline", { class: kind, points: ends.map(([v, e]) => `${x(v).toFixed(2)},${y(e).toFixed(2)}`).join(" ") });

    picture.replaceChildren();
    picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
    picture.setAttribute("width", width);
    picture.setAttribute("height", height);
    const across = step(fastest);
    for (let v = 0; v <= fastest * 1.0001; v += across) {
      line([[v, 0], [v, top]], "grid");
      add("text", { x: x(v), y: y(0) + 18, "text-anchor": "middle" }, v.toFixed(decimals(across)));
    }
    for (let e = 0; e <= top; e += 0.2) {
      line([[0, e], [fastest, e]], "grid");
      add("text", { x: margin.left - 6, y: y(e) + 4, "text-anchor": "end" }, e.toFixed(1));
    }
    add("text", { x: x(fastest / 2), y: height - 8, "text-anchor": "middle" }, "impact speed v / (m/s)");
    add("text", { x: 14, y: y(top / 2), "text-anchor": "middle", transform: `rotate(-90 14 ${y(top / 2)})` }, "restitution e_n");

    if (pair.band.length) {
      const low = speeds.map((v, i) => [v, pair.band[i][0]]);
      const high = speeds.map((v, i) => [v, pair.band[i][1]]);
      line([...low, ...high.reverse()], "band");
    }
    const curve = speeds.map((v, i) => [v, pair.restitution[i]]);
    const [slowest, last] = pair.measured.length ? pair.measured : [Infinity, -Infinity];
    // the parts meet at a point that both have
    const begin = curve.findIndex(([v]) => v >= slowest);
    const end = curve.findLastIndex(([v]) => v <= last);
    if (begin >= 0 && end > begin) {
      line(curve.slice(0, begin + 1), "curve beyond");
      line(curve.slice(begin, end + 1), "curve");
      line(curve.slice(end), "curve beyond");
    } else {
      line(curve, "curve beyond");
    }
    for (const [v, e, se] of pair.rebounds) {
      if (se > 0) line([[v, e - se], [v, e + se]], "error");
      add("circle", { class: "rebound", cx: x(v), cy: y(e), r: 3.5 });
    }
    for (const v of pair.stuck) add("circle", { class: "stuck", cx: x(v), cy: y(0), r: 4 });
    line([[speeds[place], 0], [speeds[place], top]], "cursor");
    add("circle", { class: "picked", cx: x(speeds[place]), cy: y(pair.restitution[place]), r: 5 });
  };

  const show = () => {
    const pair = pairs[picker.value];
    const place = Number(slider.value);
    const v = speeds[place];
    const e = pair.restitution[place];
    const band = pair.band.length ? `, 90 % between ${pair.band[place].map((end) => end.toFixed(4)).join(" and ")}` : "";
    const [slowest, last] = pair.measured;
    const outside = !(v >= slowest && v <= last) ? "; outside the speeds of its runs" : "";
    const rebound = e > 0 ? `e_n = ${e.toFixed(4)}${band}` : "no rebound";
    answer.textContent = `${pair.name}, v = ${v.toFixed(Math.max(2, decimals(speeds[0])))} m/s: ${rebound}${outside}`;
    slider.setAttribute("aria-valuetext", `${v} m/s`);
    draw(pair, place);
  };

  // a pair opens at the middle of its runs
  const open = () => {
    const { measured } = pairs[picker.value];
    const middle = measured.length ? (measured[0] + measured[1]) / 2 : fastest / 2;
    slider.value = Math.max(0, speeds.findIndex((v) => v >= middle));
    show();
  };
  picker.addEventListener("change", open);
  slider.addEventListener("input", show);
  addEventListener("resize", show);
  picker.value = Math.max(0, pairs.findIndex(({ wet }) => wet));
  open();
})();
