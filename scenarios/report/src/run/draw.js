'use strict';
// How a panel and its curves are drawn.

const LIGHT = { text: '#222222', quiet: '#666666', rule: '#e2e2e2' };
const DARK = { text: '#dddddd', quiet: '#9a9a9a', rule: '#3a3c3e' };
const isDark = matchMedia('(prefers-color-scheme: dark)');
let isPrinting = false;

function colours() {
  return isDark.matches && !isPrinting ? DARK : LIGHT;
}

function drawPanel(panel, curves, view, unit) {
  const { canvas, shown, words } = panel;
  const pen = penOf(canvas);
  const { text, quiet, rule } = colours();
  const place = area(canvas);
  const x = (time) => place.left + ((time - view.from) / (view.to - view.from)) * place.width;
  const y = (value) => place.top + ((shown[1] - value) / (shown[1] - shown[0])) * place.height;
  pen.fillStyle = quiet;
  pen.strokeStyle = rule;
  drawTimes(pen, place, view, x, unit);
  if (words.length) drawWords(pen, place, words, y);
  else drawValues(pen, place, shown, y);
  pen.textAlign = 'left';
  pen.fillText(panel.unit, 2, place.top + place.height + 13);
  pen.save();
  pen.beginPath();
  pen.rect(place.left, place.top, place.width, place.height);
  pen.clip();
  if (panel.quantity) {
    pen.fillStyle = text;
    pen.fillText(panel.quantity, place.left + 6, place.top + 12);
  }
  drawMarks(pen, place, panel.marks, x, quiet);
  for (const curve of curves) drawCurve(pen, curve, view, { x, y, width: place.width });
  drawCursors(pen, place, view.cursors, x, text);
  if (view.marked) {
    pen.fillStyle = `${quiet}33`;
    const [left, right] = view.marked.map(x);
    pen.fillRect(left, place.top, right - left, place.height);
  }
  pen.restore();
}

function drawWords(pen, place, words, y) {
  pen.textAlign = 'right';
  words.forEach((word, n) => {
    const at = Math.round(y(n)) + 0.5;
    pen.beginPath();
    pen.moveTo(place.left, at);
    pen.lineTo(place.left + place.width, at);
    pen.stroke();
    pen.fillText(word, place.left - 5, at + 4);
  });
}

function drawMarks(pen, place, marks, x, colour) {
  pen.strokeStyle = colour;
  pen.setLineDash([1, 3]);
  for (const mark of marks) {
    pen.beginPath();
    pen.moveTo(x(mark), place.top);
    pen.lineTo(x(mark), place.top + place.height);
    pen.stroke();
  }
  pen.setLineDash([]);
}

const DASHES = { dotted: [2, 3], dashed: [7, 4] };

function drawCurve(pen, curve, view, scale) {
  const { levels, look } = curve;
  pen.strokeStyle = pen.fillStyle = curve.colour;
  pen.lineWidth = 1.3;
  pen.setLineDash(DASHES[look] ?? []);
  for (const { level, from, to, isCycles } of levels.pieces(view.from, view.to, scale.width)) {
    const first = Math.max(0, level.find(from) - 1);
    const end = Math.min(level.length, level.find(to) + 1);
    const each = (level.each / (view.to - view.from)) * scale.width;
    const isPoints = isCycles || levels.isPoints;
    if (end - first > 2 * scale.width) drawBands(pen, columns(level, first, end, scale));
    else if (look === 'steps') drawBands(pen, boxes(level, first, end, scale));
    else if (isPoints) drawPoints(pen, level, first, end, scale, isCycles ? each > 6 : look === 'dots' && each > 4);
    else drawBands(pen, boxes(level, first, end, scale, from, to));
  }
  pen.setLineDash([]);
}

// A line through points, and the points themselves where there is room for them.
function drawPoints(pen, level, first, end, { x, y }, hasDots) {
  pen.beginPath();
  let isDown = false;
  for (let n = first; n < end; n++) {
    if (Number.isNaN(level.low[n])) {
      isDown = false;
      continue;
    }
    const [at, height] = [x(level.times[n]), y(level.low[n])];
    if (isDown) pen.lineTo(at, height);
    else pen.moveTo(at, height);
    isDown = true;
  }
  pen.stroke();
  if (!hasDots) return;
  for (let n = first; n < end; n++) {
    pen.beginPath();
    pen.arc(x(level.times[n]), y(level.low[n]), 2.2, 0, 7);
    pen.fill();
  }
}

// What a level is on each column of pixels, in runs without gaps: [left, right, lowest, highest].
function columns(level, first, end, { x, y }) {
  const runs = [[]];
  let column;
  for (let n = first; n < end; n++) {
    if (Number.isNaN(level.low[n])) {
      runs.push([]);
      column = undefined;
      continue;
    }
    const at = Math.round(x(level.times[n]));
    const [low, high] = [y(level.low[n]), y(level.high[n])];
    if (column && column[0] === at) {
      column[2] = Math.max(column[2], low);
      column[3] = Math.min(column[3], high);
    } else {
      column = [at, at, low, high];
      runs.at(-1).push(column);
    }
    if (level.end(n) < Infinity && n + 1 < end && level.end(n) < level.times[n + 1]) {
      runs.push([]);
      column = undefined;
    }
  }
  return runs;
}

// A box for each stretch.
function boxes(level, first, end, { x, y }, from = -Infinity, to = Infinity) {
  const runs = [[]];
  for (let n = first; n < end; n++) {
    const until = Math.min(level.end(n), to, level.times[n] + (n + 1 < level.length ? Infinity : level.each));
    if (until > from && !Number.isNaN(level.low[n])) {
      runs.at(-1).push([x(Math.max(level.times[n], from)), x(until), y(level.low[n]), y(level.high[n])]);
    }
    if (n + 1 < end && level.end(n) < level.times[n + 1]) runs.push([]);
  }
  return runs;
}

// Bands between extremes; a line where those are the same.
function drawBands(pen, runs) {
  for (const run of runs.filter(({ length }) => length)) {
    pen.beginPath();
    for (const [left, right, , high] of run) lineThrough(pen, left, right, high);
    if (run.some(([, , low, high]) => low - high > 1)) {
      for (const [left, right, low] of run.toReversed()) lineThrough(pen, right, left, low);
      pen.closePath();
      pen.globalAlpha = 0.35;
      pen.fill();
      pen.globalAlpha = 1;
      pen.lineWidth = 0.8;
    }
    pen.stroke();
    pen.lineWidth = 1.3;
  }
}

function lineThrough(pen, from, to, height) {
  pen.lineTo(from, height);
  if (to !== from) pen.lineTo(to, height);
}
