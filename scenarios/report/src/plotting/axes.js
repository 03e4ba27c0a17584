'use strict';
// What plots in a browser have in common, of a run that is over and of nodes that run: ticks, numbers, axes, cursors.

// Steps of 1, 2 or 5 times a power of ten, so that there are about `count` of them.
function ticks(from, to, count) {
  const raw = (to - from) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw);
  const marks = [];
  // In a range finer than its own numbers the next mark is the same one, again and again: hence no more than were wanted.
  for (let n = Math.ceil(from / step); n * step <= to && marks.length <= count + 1; n++) marks.push(n * step);
  return { marks, decimals: Math.min(100, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))) };
}

// As short as there is room for.
function label(mark, decimals) {
  const isShort = decimals <= 6 && (Math.abs(mark) < 1e8 || mark === 0);
  return isShort ? mark.toFixed(decimals) : mark.toExponential(2);
}

// A value with so many digits that count, without the zeros behind them.
function told(value, digits = 6) {
  if (!Number.isFinite(value)) return '–';
  const rounded = Number(value.toPrecision(digits));
  const size = Math.abs(rounded);
  return size !== 0 && (size < 1e-4 || size >= 1e9) ? rounded.toExponential() : String(rounded);
}

const LEFT = 76;
const RIGHT = 22;
const BOTTOM = 18;

// The place of a pane's curves on its canvas.
function area(canvas) {
  const width = canvas.clientWidth - LEFT - RIGHT;
  const height = canvas.clientHeight - BOTTOM - 4;
  return { left: LEFT, top: 4, width: Math.max(1, width), height: Math.max(1, height) };
}

// A canvas with as many dots as the screen has, and what to draw on it with.
function penOf(canvas) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  const pen = canvas.getContext('2d');
  pen.scale(ratio, ratio);
  pen.font = '11px system-ui, sans-serif';
  pen.lineWidth = 1;
  return pen;
}

// The lines and numbers along the bottom: `x` says where a time lies, which is counted from `view.zero`.
function drawTimes(pen, place, view, x, unit) {
  const time = ticks(view.from - view.zero, view.to - view.zero, place.width / 90);
  pen.textAlign = 'center';
  for (const mark of time.marks) {
    const at = Math.round(x(mark + view.zero)) + 0.5;
    pen.beginPath();
    pen.moveTo(at, place.top);
    pen.lineTo(at, place.top + place.height);
    pen.stroke();
    pen.fillText(`${mark.toFixed(time.decimals)} ${unit}`, at, place.top + place.height + 13);
  }
}

// The lines and numbers from bottom to top: `y` says where a value lies.
function drawValues(pen, place, [low, high], y) {
  const values = ticks(low, high, place.height / 32);
  pen.textAlign = 'right';
  for (const mark of values.marks) {
    const at = Math.round(y(mark)) + 0.5;
    pen.beginPath();
    pen.moveTo(place.left, at);
    pen.lineTo(place.left + place.width, at);
    pen.stroke();
    pen.fillText(label(mark, values.decimals), place.left - 5, at + 4);
  }
}

// The cursors by their names.
function drawCursors(pen, place, cursors, x, colour) {
  pen.lineWidth = 1;
  pen.textAlign = 'left';
  for (const [name, cursor] of Object.entries(cursors)) {
    if (cursor === undefined) continue;
    pen.strokeStyle = pen.fillStyle = colour;
    pen.setLineDash([4, 3]);
    pen.beginPath();
    pen.moveTo(x(cursor), place.top);
    pen.lineTo(x(cursor), place.top + place.height);
    pen.stroke();
    pen.setLineDash([]);
    pen.fillText(name, x(cursor) + 3, place.top + 10);
  }
}

// A range around these, with some room above and below; what is constant has a range, too.
function roomAround(least, most) {
  if (least > most) return [0, 1];
  const room = (most - least) * 0.06 || Math.max(Math.abs(most) * 1e-6, 1e-6);
  return [least - room, most + room];
}

// A range that is so many times as wide, with this value where it was.
function zoomed([low, high], around, factor) {
  return [around + (low - around) * factor, around + (high - around) * factor];
}
