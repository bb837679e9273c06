// Draws every figure of #charts into the element of its name. The number drawn, or the first error, is
// left on <html> for whoever tests the page.
"use strict";

// A legend beside the plot goes below it where the page is narrow.
function make_room(layout) {
  if (layout.legend.x <= 1 || window.innerWidth > 820) return;
  Object.assign(layout.legend, {orientation: "h", x: 0, xanchor: "left", y: -0.12, yanchor: "top"});
}

async function draw() {
  await load_plotly();
  const charts = JSON.parse(document.getElementById("charts").textContent);
  const options = {responsive: true, displaylogo: false,
                   modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"]};
  for (const [name, figure] of Object.entries(charts)) {
    make_room(figure.layout);
    await Plotly.newPlot(`chart-${name}`, figure.data, figure.layout, options);
  }
  return Object.keys(charts);
}

function fit(names, width) {
  for (const name of names) Plotly.relayout(`chart-${name}`, width ? {width} : {autosize: true});
}

function complain(error) {
  document.documentElement.dataset.error = String(error);
  for (const chart of document.querySelectorAll(".chart")) {
    chart.textContent = `This figure could not be drawn: ${error}`;
  }
}

draw().then((names) => {
  document.documentElement.dataset.drawn = String(names.length);
  window.addEventListener("beforeprint", () => fit(names, 680));
  window.addEventListener("afterprint", () => fit(names));
}).catch(complain);
