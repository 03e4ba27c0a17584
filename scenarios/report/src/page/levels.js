'use strict';
// A curve as the report holds it: extremes of stretches of time, and every cycle of some windows.

const DIGITS = 'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/';
const DIGIT = new Map([...DIGITS].map((digit, n) => [digit, n]));

// The numbers of a text: differences of the first or second order, five bits a character, the sign as the lowest bit.
function numbersOf(text, step) {
  const values = [];
  const isTwice = text[0] === '2';
  let [value, scale, last, slope] = [0, 1, 0, 0];
  for (let n = 1; n < text.length; n++) {
    const digit = DIGIT.get(text[n]);
    value += (digit % 32) * scale;
    scale *= 32;
    if (digit >= 32) continue;
    const difference = value % 2 ? -(value + 1) / 2 : value / 2;
    slope = (isTwice ? slope : 0) + difference;
    last += slope;
    values.push(last * step);
    [value, scale] = [0, 1];
  }
  return Float64Array.from(values);
}

// Numbers as they are, with gaps, or of a text.
function valuesOf(numbers) {
  if (Array.isArray(numbers)) return Float64Array.from(numbers, (value) => value ?? NaN);
  return numbersOf(numbers.value, numbers.step);
}

function timesOf(times) {
  if (!Array.isArray(times)) return numbersOf(times.value, times.step);
  const [first, distance, count] = times;
  return Float64Array.from({ length: count }, (_, n) => first + n * distance);
}

// How far apart times usually are.
function usualDistance(times) {
  const all = Array.from(times.subarray(1), (time, n) => time - times[n]).sort((a, b) => a - b);
  return all.length ? all[all.length >> 1] : 0;
}

// Values from some times on, from `low` to `high`, each for `each` at most.
class Level {
  constructor(times, low, high) {
    Object.assign(this, { times, low, high, each: usualDistance(times) });
  }

  get length() {
    return this.times.length;
  }

  // When the n-th ends: with the next, if that is not later than usual.
  end(n) {
    const next = n + 1 < this.length ? this.times[n + 1] : Infinity;
    return next - this.times[n] > 1.5 * this.each ? this.times[n] + this.each : next;
  }

  // The first that is not before this time.
  find(time) {
    let [first, last] = [0, this.length];
    while (first < last) {
      const middle = (first + last) >> 1;
      if (this.times[middle] < time) first = middle + 1;
      else last = middle;
    }
    return first;
  }

  // What holds at this time; none in a gap.
  at(time) {
    const next = this.find(time);
    const n = this.times[next] === time ? next : next - 1;
    if (n < 0 || time >= this.end(n) + 1e-9) return undefined;
    return Number.isNaN(this.low[n]) ? undefined : [this.low[n], this.high[n]];
  }
}

// A curve: the level of the whole run first, then those of single cycles within it. Of points, `values` are those, and a
// level goes from the one end of their spread to the other.
class Levels {
  constructor({ data: { x, y, isCourse, stretches, windows }, look, spread }) {
    if (x) {
      this.values = valuesOf(y);
      const [low, high] = spread.map((ends) => (ends.length ? valuesOf(ends) : this.values));
      this.whole = new Level(valuesOf(x), low, high);
      this.isPoints = true;
      this.isCourse = isCourse;
      this.isNearest = look === 'dots' || look === 'marks';
      this.windows = [];
      return;
    }
    const low = numbersOf(stretches.low, stretches.step);
    const height = numbersOf(stretches.height, stretches.step);
    this.whole = new Level(timesOf(stretches.t), low, low.map((value, n) => value + height[n]));
    this.windows = windows.map((window) => {
      const values = numbersOf(window.value, window.step);
      return new Level(timesOf(window.t), values, values);
    });
  }

  first() {
    return this.whole.length ? this.whole.times[0] : Infinity;
  }

  last() {
    const { whole } = this;
    if (!whole.length) return -Infinity;
    return whole.times[whole.length - 1] + (this.isPoints ? 0 : whole.each);
  }

  // The lowest and the highest value at this time; one value within a window.
  at(time) {
    for (const window of this.windows) {
      const value = window.at(time);
      if (value) return value;
    }
    if (this.isPoints) return this.pointAt(time);
    return this.whole.at(time);
  }

  // The point that holds, as a value twice and its number: the last one before. Of single points it is the nearest one; a
  // course has a value of its own between two.
  pointAt(time) {
    const { whole, values } = this;
    const next = whole.find(time);
    if (this.isNearest) return this.point(this.nearest(time, next));
    const n = whole.times[next] === time ? next : next - 1;
    if (n < 0 || n >= whole.length || time > this.last()) return undefined;
    if (!this.isCourse || n === next) return this.point(n);
    const share = (time - whole.times[n]) / (whole.times[next] - whole.times[n]);
    const value = values[n] + share * (values[next] - values[n]);
    return Number.isNaN(value) ? undefined : [value, value];
  }

  point(n) {
    const value = this.values[n];
    return value === undefined || Number.isNaN(value) ? undefined : [value, value, n];
  }

  nearest(time, next) {
    const { times } = this.whole;
    if (next === 0 || next === times.length) return Math.min(next, times.length - 1);
    return times[next] - time < time - times[next - 1] ? next : next - 1;
  }

  // Pieces of levels between two times, in order: cycles where there are any and there is room to see them.
  pieces(from, to, width) {
    const isClose = (this.whole.each / (to - from)) * width > 1.5;
    if (!isClose) return [{ level: this.whole, from, to }];
    const pieces = [];
    let at = from;
    for (const window of this.windows) {
      const [start, end] = [window.times[0], window.times[window.length - 1]];
      if (end < at || start > to) continue;
      if (start > at) pieces.push({ level: this.whole, from: at, to: start });
      pieces.push({ level: window, from: Math.max(at, start), to: Math.min(end, to), isCycles: true });
      at = Math.min(end, to);
    }
    if (at < to) pieces.push({ level: this.whole, from: at, to });
    return pieces;
  }

  // The lowest and the highest value between two times.
  extremes(from, to, width) {
    let [least, most] = [Infinity, -Infinity];
    for (const { level, from: start, to: end } of this.pieces(from, to, width)) {
      const stop = Math.min(level.length, level.find(end) + (this.isPoints ? 1 : 0));
      for (let n = Math.max(0, level.find(start) - 1); n < stop; n++) {
        if (!this.isPoints && level.end(n) <= start) continue;
        if (level.low[n] < least) least = level.low[n];
        if (level.high[n] > most) most = level.high[n];
      }
    }
    return [least, most];
  }
}
