"use strict";
// Draws every figure of the page, in the colours of the page.
const LIGHT = { text: "#222222", quiet: "#999999", grid: "#e2e2e2" };
const DARK = { text: "#dddddd", quiet: "#777777", grid: "#3a3a3a" };
const dark = matchMedia("(prefers-color-scheme: dark)");
const plots = [...document.querySelectorAll(".plot")];

function template(colours) {
  const axis = { gridcolor: colours.grid, linecolor: colours.grid, tickcolor: colours.grid };
  return {
    layout: {
      font: { color: colours.text, family: "system-ui, sans-serif", size: 12 },
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      modebar: { bgcolor: "rgba(0,0,0,0)", color: colours.quiet, activecolor: colours.text },
      xaxis: axis,
      yaxis: axis,
    },
  };
}

function colours() {
  return dark.matches ? DARK : LIGHT;
}

// The plots over time zoom together.
let linking = false;
function zoomWith(source, event) {
  const from = event["xaxis.range[0]"];
  const to = event["xaxis.range[1]"];
  const zoom = event["xaxis.autorange"] ? { "xaxis.autorange": true }
    : from !== undefined ? { "xaxis.range": [from, to] } : null;
  if (linking || zoom === null || source.id === "beat") return;
  linking = true;
  const others = plots.filter((plot) => plot !== source && plot.id !== "beat");
  Promise.all(others.map((plot) => Plotly.relayout(plot, zoom))).finally(() => { linking = false; });
}

for (const plot of plots) {
  const figure = JSON.parse(document.getElementById(plot.id + "-figure").textContent);
  figure.layout.template = template(colours());
  Plotly.newPlot(plot, figure.data, figure.layout, {
    responsive: true,
    displaylogo: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d"],
  });
  plot.on("plotly_relayout", (event) => zoomWith(plot, event));
}

dark.addEventListener("change", () => {
  for (const plot of plots) Plotly.relayout(plot, { template: template(colours()) });
});
// Paper is white and narrow.
addEventListener("beforeprint", () => {
  for (const plot of plots) Plotly.relayout(plot, { template: template(LIGHT), width: 680 });
});
addEventListener("afterprint", () => {
  for (const plot of plots) {
    Plotly.relayout(plot, { template: template(colours()), width: null, autosize: true });
  }
});
