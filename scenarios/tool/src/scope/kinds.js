'use strict';
// What a window shows otherwise than over time: signals against another one, and the frequencies in them.

// So many of the newest rows of the window at most.
const MOST_IN_SPECTRUM = 2 ** 16;
const LEAST_IN_SPECTRUM = 16;

// Amplitudes of the frequencies in a signal between two times, without its mean and slope, each `step` Hz further; none where many rows are missing at once, or there are too few.
// Behind a Hann window: a sine between two of the frequencies is up to 15 % too small.
function spectrumOf(rows, name, from, to) {
  const end = rows.find(to);
  const count = end - rows.find(from);
  if (count < LEAST_IN_SPECTRUM) return undefined;
  const size = Math.min(MOST_IN_SPECTRUM, 2 ** Math.floor(Math.log2(count)));
  const even = evenly(rows.times.subarray(end - size, end), rows.columns.get(name).subarray(end - size, end));
  const real = even && levelled(even.values);
  if (!real) return undefined;
  const { apart } = even;
  const imaginary = new Float64Array(size);
  // The window leaves half of an amplitude, which is in two frequencies, one of them negative.
  for (let n = 0; n < size; n++) real[n] *= 1 - Math.cos((2 * Math.PI * n) / size);
  transform(real, imaginary);
  const amplitudes = new Float64Array(size / 2);
  for (let n = 1; n < amplitudes.length; n++) amplitudes[n] = (2 * Math.hypot(real[n], imaginary[n])) / size;
  return { step: 1 / (size * apart), amplitudes };
}

// Values at even times, as cycles that a busy machine skips are not there; none where much is missing at once.
function evenly(times, values) {
  const size = times.length;
  const whole = times[size - 1] - times[0];
  const apart = whole / (size - 1);
  if (times.some((time, n) => n > 0 && time - times[n - 1] > whole / LEAST_IN_SPECTRUM)) return undefined;
  let row = 1;
  const even = Float64Array.from({ length: size }, (_, n) => {
    const time = times[0] + n * apart;
    while (row < size - 1 && times[row] < time) row++;
    const share = (time - times[row - 1]) / (times[row] - times[row - 1]);
    return values[row - 1] + share * (values[row] - values[row - 1]);
  });
  return { apart, values: even };
}

// Values without their straight line of least squares; none where one of them is not known.
function levelled(values) {
  const size = values.length;
  const middle = (size - 1) / 2;
  let [sum, moment] = [0, 0];
  values.forEach((value, n) => {
    sum += value;
    moment += value * (n - middle);
  });
  const slope = moment / ((size * (size * size - 1)) / 12);
  if (Number.isNaN(slope)) return undefined;
  return values.map((value, n) => value - sum / size - slope * (n - middle));
}

// Discrete Fourier transform in place, of a power of two of values (Cooley and Tukey).
function transform(real, imaginary) {
  const size = real.length;
  for (let n = 1, other = 0; n < size; n++) {
    let bit = size >> 1;
    for (; other & bit; bit >>= 1) other ^= bit;
    other ^= bit;
    if (n < other) {
      [real[n], real[other]] = [real[other], real[n]];
      [imaginary[n], imaginary[other]] = [imaginary[other], imaginary[n]];
    }
  }
  for (let half = 1; half < size; half *= 2) {
    for (let n = 0; n < half; n++) {
      const angle = (-Math.PI * n) / half;
      const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
      for (let even = n; even < size; even += 2 * half) {
        const odd = even + half;
        const turned = real[odd] * cosine - imaginary[odd] * sine;
        const across = real[odd] * sine + imaginary[odd] * cosine;
        [real[odd], imaginary[odd]] = [real[even] - turned, imaginary[even] - across];
        real[even] += turned;
        imaginary[even] += across;
      }
    }
  }
}

// Draws the frequencies of a pane's curves, and gives the range of amplitudes that it shows.
function drawSpectrum(canvas, curves, view, range, unit) {
  const shown = curves.map((curve) => ({ ...curve, spectrum: spectrumOf(curve.rows, curve.name, view.from, view.to) }))
    .filter(({ spectrum }) => spectrum);
  const highest = Math.max(1, ...shown.map(({ spectrum }) => spectrum.step * spectrum.amplitudes.length));
  const most = Math.max(0, ...shown.map(({ spectrum }) => spectrum.amplitudes.reduce((a, b) => Math.max(a, b), 0)));
  const frame = begin(canvas, { from: 0, to: highest, zero: 0 }, 'Hz', range ?? [0, 1.06 * most || 1], unit);
  for (const { spectrum, colour } of shown) {
    const { amplitudes, step } = spectrum;
    line(frame, colour, amplitudes.length, (n) => [n * step, amplitudes[n]]);
  }
  if (!shown.length) frame.pen.fillText('too few rows, or many are missing', frame.place.left + 8, frame.place.top + 14);
  frame.pen.restore();
  return frame.shown;
}

// Draws a pane's curves against another one, and gives the range of values that it shows.
function drawAgainst(canvas, curves, across, view, range, unit) {
  const { from, to } = view;
  const [least, most] = fit([across], view);
  const frame = begin(canvas, { from: least, to: most, zero: 0 }, across.unit, range ?? fit(curves, view), unit);
  for (const { rows, name, colour } of curves) {
    const start = rows.find(from);
    const column = rows.columns.get(name);
    const other = across.rows.columns.get(across.name);
    // Of another node the value that holds at that time.
    const beside = (row) => (across.rows === rows ? other[row] : across.rows.at(across.name, rows.times[row]));
    line(frame, colour, rows.find(to) - start, (n) => [beside(start + n), column[start + n]]);
  }
  frame.pen.restore();
  return frame.shown;
}

function line({ pen, x, y }, colour, count, pointOf) {
  pen.strokeStyle = colour;
  pen.lineWidth = 1.3;
  pen.beginPath();
  let isDown = false;
  for (let n = 0; n < count; n++) {
    const [right, up] = pointOf(n);
    const isKnown = !Number.isNaN(right) && !Number.isNaN(up);
    if (isKnown && isDown) pen.lineTo(x(right), y(up));
    else if (isKnown) pen.moveTo(x(right), y(up));
    isDown = isKnown;
  }
  pen.stroke();
}
