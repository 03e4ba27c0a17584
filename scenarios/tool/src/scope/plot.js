'use strict';
// Rows of signals over time, and how they are drawn.

// The newest rows of some signals: times, and a column of values for each signal.
class Rows {
  constructor(names, most) {
    this.names = names;
    this.most = most;
    this.length = 0;
    this.times = new Float64Array(most);
    this.columns = new Map(names.map((name) => [name, new Float64Array(most)]));
    this.pyramids = new Map([...this.columns].map(([name, column]) => [name, new Pyramid(column)]));
  }

  // Adds rows; what no longer fits makes room a quarter at a time, so that it is not moved for every block.
  push(times, columns) {
    const count = Math.min(times.length, this.most >> 2);
    if (this.length + count > this.most) {
      this.drop(Math.max(count, this.most >> 2));
    }
    const from = times.length - count;
    this.times.set(times.subarray(from), this.length);
    this.names.forEach((name, n) => this.columns.get(name).set(columns[n].subarray(from), this.length));
    this.length += count;
    this.update(this.length - count);
  }

  // The first rows go: at least so many.
  drop(least) {
    const block = this.pyramids.values().next().value?.largest() ?? 1;
    const gone = Math.ceil(least / block) * block;
    this.times.copyWithin(0, gone, this.length);
    for (const column of this.columns.values()) column.copyWithin(0, gone, this.length);
    for (const pyramid of this.pyramids.values()) pyramid.drop(gone);
    this.length = Math.max(0, this.length - gone);
  }

  update(from) {
    for (const pyramid of this.pyramids.values()) pyramid.update(from, this.length);
  }

  // Nothing is known of a signal any more.
  forget(name) {
    this.columns.get(name).fill(NaN, 0, this.length);
    this.pyramids.get(name).update(0, this.length);
  }

  // Takes over what another one has of the same signals.
  adopt(other) {
    const count = Math.min(other.length, this.most);
    const from = other.length - count;
    this.times.set(other.times.subarray(from, other.length));
    for (const [name, column] of this.columns) {
      const known = other.columns.get(name);
      if (known) column.set(known.subarray(from, other.length));
      else column.fill(NaN, 0, count);
    }
    this.length = count;
    this.update(0);
  }

  last() {
    return this.length ? this.times[this.length - 1] : undefined;
  }

  // The first row that is not before this time.
  find(time) {
    let [low, high] = [0, this.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // The value that holds at this time.
  at(name, time) {
    const row = this.find(time);
    const held = row < this.length && this.times[row] === time ? row : row - 1;
    return held >= 0 ? this.columns.get(name)[held] : NaN;
  }

  // Of a signal from one time to another.
  figures(name, from, to) {
    const pyramid = this.pyramids.get(name);
    const [first, end] = [this.find(from), this.find(to)];
    const [sum, squares, count] = pyramid.summed(first, end);
    pyramid.range(first, end);
    const { least, most } = pyramid;
    return count ? { least, most, mean: sum / count, rms: Math.sqrt(squares / count) } : undefined;
  }

  // The first time after `since` at which the signal goes through the level.
  crossing(name, since, level, rising) {
    const column = this.columns.get(name);
    for (let row = Math.max(1, this.find(since)); row < this.length; row++) {
      const [before, now] = [column[row - 1], column[row]];
      if (rising ? before < level && now >= level : before > level && now <= level) return this.times[row];
    }
    return undefined;
  }
}

// Draws a pane: `view` is { from, to } in seconds, `cursors` are times, `curves` are { rows, name, colour, words }.
// Gives the range of values that it shows.
function draw(canvas, curves, view, cursors, range, unit) {
  const isWords = curves.every((curve) => curve.words);
  const shown = isWords ? [0, curves.length] : range ?? fit(curves, view);
  const { pen, place, x, y } = begin(canvas, view, 's', shown, unit, isWords);
  curves.forEach((curve, lane) => {
    if (isWords) drawWords(pen, curve, view, x, place.top + (lane / curves.length) * place.height,
      place.height / curves.length);
    else drawCurve(pen, curve, view, x, y, place);
  });
  drawCursors(pen, place, cursors, x, getComputedStyle(document.body).getPropertyValue('--text'));
  pen.restore();
  return shown;
}

// Begins a pane: its axes, lanes of words have none from bottom to top. Gives what to draw with and where values lie; until the pen is restored, nothing
// is drawn beside that place.
function begin(canvas, bottom, bottomUnit, shown, unit, isWords = false) {
  const pen = penOf(canvas);
  const style = getComputedStyle(document.body);
  const place = area(canvas);
  const x = (value) => place.left + ((value - bottom.from) / (bottom.to - bottom.from)) * place.width;
  const y = (value) => place.top + ((shown[1] - value) / (shown[1] - shown[0])) * place.height;
  pen.fillStyle = style.getPropertyValue('--quiet');
  pen.strokeStyle = style.getPropertyValue('--rule');
  drawTimes(pen, place, bottom, x, bottomUnit);
  if (!isWords) drawValues(pen, place, shown, y);
  pen.textAlign = 'left';
  pen.fillText(unit, 2, place.top + place.height + 13);
  pen.save();
  pen.beginPath();
  pen.rect(place.left, place.top, place.width, place.height);
  pen.clip();
  return { pen, place, x, y, shown };
}

// The values between two times, with some room above and below.
function fit(curves, view) {
  let [least, most] = [Infinity, -Infinity];
  for (const { rows, name } of curves) {
    const pyramid = rows.pyramids.get(name);
    pyramid.range(rows.find(view.from), rows.find(view.to));
    least = Math.min(least, pyramid.least);
    most = Math.max(most, pyramid.most);
  }
  return roomAround(least, most);
}

// The first row of each pixel, and the one after the last: all curves of the same rows share them.
const EDGES = new WeakMap();

function edgesOf(rows, view, width) {
  const known = EDGES.get(rows);
  const of = [view.from, view.to, width, rows.length, rows.last()];
  if (known && known.of.every((value, n) => value === of[n])) return known.edges;
  const edges = new Int32Array(Math.ceil(width) + 1);
  const each = (view.to - view.from) / width;
  for (let pixel = 0; pixel < edges.length; pixel++) edges[pixel] = rows.find(view.from + pixel * each);
  EDGES.set(rows, { of, edges });
  return edges;
}

const known = (value, otherwise) => (Number.isNaN(value) ? otherwise : value);

// More rows than pixels become a vertical stroke each pixel, from the least to the most: no peak is lost.
function drawCurve(pen, { rows, name, colour }, view, x, y, place) {
  const column = rows.columns.get(name);
  const start = Math.max(0, rows.find(view.from) - 1);
  const stop = Math.min(rows.length, rows.find(view.to) + 1);
  pen.strokeStyle = colour;
  pen.lineWidth = 1.3;
  pen.beginPath();
  let isDown = false;
  const to = (at, value) => {
    if (isDown) pen.lineTo(at, value);
    else pen.moveTo(at, value);
    isDown = true;
  };
  if (stop - start < 2 * place.width) {
    for (let row = start; row < stop; row++) {
      if (Number.isNaN(column[row])) isDown = false;
      else to(x(rows.times[row]), y(column[row]));
    }
  } else {
    const pyramid = rows.pyramids.get(name);
    const edges = edgesOf(rows, view, place.width);
    for (let pixel = 0; pixel + 1 < edges.length; pixel++) {
      const last = edges[pixel + 1] - 1;
      pyramid.range(edges[pixel], last + 1);
      const least = pyramid.least;
      const most = pyramid.most;
      if (least > most) {
        // Pixels without any row are crossed; where values are not known the curve has a gap.
        if (last >= edges[pixel]) isDown = false;
        continue;
      }
      const at = place.left + pixel;
      // A constant is one point a pixel, a slope two.
      const first = known(column[edges[pixel]], least);
      const end = known(column[last], least);
      to(at, y(first));
      if (least < first && least < end) pen.lineTo(at, y(least));
      if (most > first && most > end) pen.lineTo(at, y(most));
      if (end !== first) pen.lineTo(at, y(end));
    }
  }
  pen.stroke();
}

// States: a band with a word for as long as it holds.
function drawWords(pen, { rows, name, colour, words }, view, x, top, height) {
  const column = rows.columns.get(name);
  const pyramid = rows.pyramids.get(name);
  const end = Math.min(rows.length, rows.find(view.to) + 1);
  let row = Math.max(0, rows.find(view.from) - 1);
  while (row < end) {
    const number = column[row];
    const from = x(rows.times[row]);
    row = pyramid.change(row, end);
    if (Number.isNaN(number)) continue;
    const to = row < rows.length ? x(rows.times[row]) : from + 1e4;
    const left = Math.max(from, LEFT);
    pen.globalAlpha = 0.18;
    pen.fillStyle = colour;
    pen.fillRect(left, top + 2, Math.min(to, 1e5) - left - 1, height - 4);
    pen.globalAlpha = 1;
    if (to - left > 24) pen.fillText(words[number] ?? '', left + 4, top + height / 2 + 4, to - left - 6);
  }
}
