'use strict';
// Where values lie, and how a panel and its curves are drawn.

const LIGHT = { text: '#222222', quiet: '#666666', rule: '#e2e2e2' };
const DARK = { text: '#dddddd', quiet: '#9a9a9a', rule: '#3a3c3e' };
const isDark = matchMedia('(prefers-color-scheme: dark)');
let isPrinting = false;

function colours() {
  return isDark.matches && !isPrinting ? DARK : LIGHT;
}

// The value that a place on a scale stands for.
function valueAt(scale, place) {
  if (scale === 'logarithmic') return 10 ** place;
  return scale === 'backwards' ? -place : place;
}

// Powers of ten; with their doubles and fivefolds where the decades are few, and as on a linear scale within one.
function decades([from, to], count) {
  if (to - from < 1) {
    const { marks } = ticks(10 ** from, 10 ** to, count);
    return marks.map((value) => ({ at: Math.log10(value), text: told(value, 6) }));
  }
  const factors = 3 * (to - from) <= count ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil((to - from) / count));
  const marks = [];
  for (let decade = Math.floor(from / every) * every; decade <= to; decade += every) {
    for (const factor of factors) marks.push({ at: decade + Math.log10(factor), text: told(factor * 10 ** decade, 3) });
  }
  return marks.filter(({ at }) => at >= from - 1e-9 && at <= to + 1e-9);
}

// Some of the words, so that they fit.
function someWords(words, [from, to], count) {
  const step = Math.max(1, Math.ceil((to - from) / Math.max(1, count)));
  return words.map((text, at) => ({ at, text })).filter(({ at }) => at % step === 0 && at >= from && at <= to);
}

// What is labelled on a scale that is not linear.
function marksOf(scale, words, range, count) {
  if (scale === 'words') return someWords(words, range, count);
  if (scale === 'logarithmic') return decades(range, count);
  const { marks, decimals } = ticks(...range, count);
  return marks.map((at) => ({ at, text: label(valueAt(scale, at), decimals) }));
}

// The lines and words along the bottom.
function drawAcross(pen, place, view, x, { unit, across }) {
  if (across.scale === 'linear') {
    drawTimes(pen, place, view, x, unit);
    return;
  }
  const longest = Math.max(50, ...across.labels.map((word) => pen.measureText(word).width));
  pen.textAlign = 'center';
  for (const { at, text } of marksOf(across.scale, across.labels, [view.from, view.to], place.width / (longest + 20))) {
    const left = Math.round(x(at)) + 0.5;
    pen.beginPath();
    pen.moveTo(left, place.top);
    pen.lineTo(left, place.top + place.height);
    pen.stroke();
    pen.fillText(`${text} ${unit}`, left, place.top + place.height + 13);
  }
}

function drawPanel(panel, curves, view, figure) {
  const { canvas, shown } = panel;
  const pen = penOf(canvas);
  const { text, quiet, rule } = colours();
  const place = area(canvas);
  const x = (time) => place.left + ((time - view.from) / (view.to - view.from)) * place.width;
  const y = (value) => place.top + ((shown[1] - value) / (shown[1] - shown[0])) * place.height;
  pen.fillStyle = quiet;
  pen.strokeStyle = rule;
  drawAcross(pen, place, view, x, figure);
  if (panel.scale === 'linear') drawValues(pen, place, shown, y);
  else drawMarksUp(pen, place, marksOf(panel.scale, panel.words, shown, place.height / 20), y);
  pen.textAlign = 'left';
  pen.fillText(panel.unit, 2, place.top + place.height + 13);
  pen.save();
  pen.beginPath();
  pen.rect(place.left, place.top, place.width, place.height);
  pen.clip();
  drawMarks(pen, place, panel.marks, x, quiet);
  const scale = { x, y, width: place.width };
  for (const curve of curves) drawSpread(pen, curve, scale);
  for (const curve of curves) drawCurve(pen, curve, view, scale);
  drawCursors(pen, place, view.cursors, x, text);
  if (view.marked) {
    pen.fillStyle = `${quiet}33`;
    const [left, right] = view.marked.map(x);
    pen.fillRect(left, place.top, right - left, place.height);
  }
  pen.restore();
}

// The lines and words from bottom to top.
function drawMarksUp(pen, place, marks, y) {
  pen.textAlign = 'right';
  for (const { at, text } of marks) {
    const height = Math.round(y(at)) + 0.5;
    pen.beginPath();
    pen.moveTo(place.left, height);
    pen.lineTo(place.left + place.width, height);
    pen.stroke();
    pen.fillText(text, place.left - 5, height + 4);
  }
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
    if (look === 'marks') drawDots(pen, level, levels.values, first, end, scale, 3.5);
    else if (levels.isCourse) drawPoints(pen, level, levels.values, first, end, scale, false);
    else if (end - first > 2 * scale.width) drawBands(pen, columns(level, first, end, scale));
    else if (look === 'steps') drawBands(pen, boxes(level, first, end, scale));
    else if (isPoints) {
      const values = isCycles ? level.low : levels.values;
      drawPoints(pen, level, values, first, end, scale, isCycles ? each > 6 : look === 'dots' && !(each <= 4));
    }
    else drawBands(pen, boxes(level, first, end, scale, from, to));
  }
  pen.setLineDash([]);
}

// A line through points, and the points themselves where there is room for them.
function drawPoints(pen, level, values, first, end, scale, hasDots) {
  const { x, y } = scale;
  pen.beginPath();
  let isDown = false;
  for (let n = first; n < end; n++) {
    if (Number.isNaN(values[n])) {
      isDown = false;
      continue;
    }
    const [at, height] = [x(level.times[n]), y(values[n])];
    if (isDown) pen.lineTo(at, height);
    else pen.moveTo(at, height);
    isDown = true;
  }
  pen.stroke();
  if (hasDots) drawDots(pen, level, values, first, end, scale, 2.2);
}

function drawDots(pen, level, values, first, end, { x, y }, radius) {
  for (let n = first; n < end; n++) {
    if (Number.isNaN(values[n])) continue;
    pen.beginPath();
    pen.arc(x(level.times[n]), y(values[n]), radius, 0, 7);
    pen.fill();
  }
}

// The spread of points: a band from one to the next, and a whisker at each.
function drawSpread(pen, { levels, colour, spread }, { x, y }) {
  if (!spread[0].length) return;
  const { whole } = levels;
  pen.strokeStyle = pen.fillStyle = colour;
  const runs = [[]];
  for (let n = 0; n < whole.length; n++) {
    if (Number.isNaN(whole.low[n]) || Number.isNaN(whole.high[n])) runs.push([]);
    else runs.at(-1).push([x(whole.times[n]), y(whole.low[n]), y(whole.high[n])]);
  }
  for (const run of runs) {
    pen.beginPath();
    for (const [at, , high] of run) pen.lineTo(at, high);
    for (const [at, low] of run.toReversed()) pen.lineTo(at, low);
    pen.globalAlpha = 0.2;
    pen.fill();
    pen.globalAlpha = 1;
    pen.beginPath();
    for (const [at, low, high] of run) {
      for (const end of [low, high]) {
        pen.moveTo(at - 3, end);
        pen.lineTo(at + 3, end);
      }
      pen.moveTo(at, low);
      pen.lineTo(at, high);
    }
    pen.stroke();
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
