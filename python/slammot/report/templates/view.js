// The map in three dimensions, with a slider through time. As in page.js, what was drawn or the first
// error is left on <html> for whoever tests the page. Plotly's up is z; the world's y points down.
"use strict";

const COLOURS = ["#CC79A7", "#0072B2", "#D55E00"];  // unknown, static, moving
const SYMBOLS = ["square-open", "circle", "diamond"];
const PATH = "#009E73";
const NAMES = ["undecided", "static", "moving"];
const SIDES = 16;

function line(name, points, colour, width, dash) {
  return {type: "scatter3d", mode: "lines", name, x: points.map((p) => p[0]), y: points.map((p) => p[2]),
          z: points.map((p) => -p[1]), line: {color: colour, width, dash}, hoverinfo: "name"};
}

function centres(landmarks, label) {
  const own = landmarks.filter((l) => l[0] === label);
  return {type: "scatter3d", mode: "markers", name: NAMES[label], x: own.map((l) => l[1]), y: own.map((l) => l[3]),
          z: own.map((l) => -l[2]), marker: {color: COLOURS[label], symbol: SYMBOLS[label], size: 6, opacity: 0.8}, hoverinfo: "name"};
}

// Three ellipses through the half axes of each ellipsoid, in one trace with gaps.
function ellipsoids(landmarks, label) {
  const x = [], y = [], z = [];
  for (const l of landmarks) {
    if (l[0] !== label) continue;
    const axes = [l.slice(4, 7), l.slice(7, 10), l.slice(10, 13)];
    for (const [a, b] of [[0, 1], [1, 2], [0, 2]]) {
      for (let i = 0; i <= SIDES; ++i) {
        const c = Math.cos(2 * Math.PI * i / SIDES), s = Math.sin(2 * Math.PI * i / SIDES);
        const p = [0, 1, 2].map((k) => l[1 + k] + c * axes[a][k] + s * axes[b][k]);
        x.push(p[0]); y.push(p[2]); z.push(-p[1]);
      }
      x.push(null); y.push(null); z.push(null);
    }
  }
  return {type: "scatter3d", mode: "lines", name: `${NAMES[label]}, 95%`, x, y, z, hoverinfo: "skip",
          line: {color: COLOURS[label], width: 1}, opacity: 0.6, showlegend: false};
}

function traces(run, step) {
  const {landmarks, camera, truth, done} = run.steps[step];
  const here = truth ? [camera, truth] : [camera];
  return [
    line("true path", run.truth_path, "#000000", 2, "dash"),
    line("estimated path", run.path.slice(0, Math.max(2, done)), PATH, 5, "solid"),
    {type: "scatter3d", mode: "markers", name: "camera", x: here.map((p) => p[0]), y: here.map((p) => p[2]),
     z: here.map((p) => -p[1]), marker: {color: [PATH, "#000000"], size: 8, symbol: "cross"}},
    ...[0, 1, 2].map((label) => centres(landmarks, label)),
    ...[0, 1, 2].map((label) => ellipsoids(landmarks, label)),
  ];
}

async function start() {
  await load_plotly();
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const choice = document.getElementById("view-run"), slider = document.getElementById("view-step");
  data.runs.forEach((run, i) => choice.add(new Option(run.label, String(i))));
  const layout = {margin: {l: 0, r: 0, t: 0, b: 0}, uirevision: "kept", legend: {x: 0, y: 1},
                  scene: {aspectmode: "data", xaxis: {title: "x [m]"}, yaxis: {title: "z [m]"},
                          zaxis: {title: "-y [m]"}}};
  const draw = async () => {
    const run = data.runs[Number(choice.value)];
    slider.max = String(run.steps.length - 1);
    const step = Math.min(Number(slider.value), run.steps.length - 1);
    const {frame, timestamp, landmarks} = run.steps[step];
    document.getElementById("view-time").textContent = `frame ${frame}, ${timestamp.toFixed(2)} s`;
    await Plotly.react("view", traces(run, step), layout, {responsive: true, displaylogo: false});
    return landmarks.length;
  };
  slider.value = slider.max = String(data.runs[0].steps.length - 1);
  choice.addEventListener("change", draw);
  slider.addEventListener("input", draw);
  document.documentElement.dataset.landmarks = String(await draw());
  const drawn = document.getElementById("view").data.map((trace) => trace.x.length);
  document.documentElement.dataset.marks = String(drawn.reduce((a, b) => a + b, 0));
  document.documentElement.dataset.drawn = "1";
}

start().catch((error) => {
  document.documentElement.dataset.error = String(error);
  document.getElementById("view").textContent = `The view could not be drawn: ${error}`;
});
