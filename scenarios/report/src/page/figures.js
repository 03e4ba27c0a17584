'use strict';
// Every figure of the page: drawn, zoomed, moved, measured.

const MOST_TOLD = 24;
// Pixels from the pointer to a mark that it is on.
const REACH = 9;

function element(kind, parent, name, text) {
  const made = document.createElement(kind);
  if (name) made.className = name;
  if (text !== undefined) made.textContent = text;
  parent?.append(made);
  return made;
}

// --- What is seen: the figures over one axis together

class View {
  constructor() {
    Object.assign(this, { from: 0, to: 1, zero: 0, all: [Infinity, -Infinity], cursors: {}, figures: [] });
  }

  add(figure) {
    this.figures.push(figure);
    const [from, to] = figure.told.extent;
    this.all = [Math.min(this.all[0], from), Math.max(this.all[1], to)];
    [this.from, this.to] = this.all;
  }

  isAll() {
    return this.from === this.all[0] && this.to === this.all[1];
  }

  // Shows from one time to another, within what there is.
  show(from, to) {
    const [first, last] = this.all;
    const span = Math.min(last - first, Math.max((last - first) * 1e-8, to - from));
    const isAll = span === last - first;
    this.from = isAll ? first : Math.min(Math.max(first, from), last - span);
    this.to = isAll ? last : this.from + span;
    this.redraw();
  }

  showAll() {
    for (const figure of this.figures) for (const panel of figure.panels) panel.chosen = undefined;
    this.show(...this.all);
  }

  set(cursor, time) {
    this.cursors[cursor] = time;
    for (const figure of this.figures) figure.measure();
    this.redraw();
  }

  redraw() {
    for (const figure of this.figures) figure.isDirty = true;
    request();
  }
}

const views = new Map();

// --- A figure

class Figure {
  constructor(place) {
    const told = JSON.parse(document.getElementById(`${place.id}-figure`).textContent);
    Object.assign(this, { place, told, hidden: new Set(), isDirty: true });
    this.panels = told.panels.map((panel) => this.panel(panel));
    this.curves = this.panels.flatMap((panel) => panel.curves);
    element('div', place, 'across', told.across.words);
    this.legend();
    this.measured = element('table', place, 'measured');
    this.tip = element('div', place, 'tip');
    this.tip.hidden = true;
    const key = told.unit || told.across.words;
    if (!views.has(key)) views.set(key, new View());
    this.view = views.get(key);
    this.view.add(this);
  }

  panel(told) {
    const heading = told.title || (told.unit ? told.quantity && `${told.quantity} (${told.unit})` : told.quantity);
    if (heading) element('div', this.place, 'panel-title', heading);
    const canvas = element('canvas', this.place);
    canvas.style.height = `${told.height}px`;
    const curves = told.curves.map((curve) => ({ ...curve, unit: told.unit, levels: new Levels(curve) }));
    const panel = { ...told, canvas, curves };
    handle(this, panel);
    return panel;
  }

  legend() {
    const legend = element('div', this.place, 'legend');
    const groups = new Map(this.curves.map((curve) => [curve.group, curve]));
    for (const [group, { colour, look }] of groups) {
      const button = element('button', legend);
      const swatch = element('i', button);
      swatch.style.borderColor = colour;
      swatch.style.borderTopStyle = { dashed: 'dashed', dotted: 'dotted', marks: 'dotted' }[look] ?? 'solid';
      button.append(group);
      button.setAttribute('aria-pressed', 'true');
      button.addEventListener('click', () => {
        const isHidden = !this.hidden.delete(group);
        if (isHidden) this.hidden.add(group);
        button.setAttribute('aria-pressed', String(!isHidden));
        this.measure();
        this.view.redraw();
      });
    }
    const keep = element('button', legend, 'keep', 'save as PNG');
    keep.addEventListener('click', () => keepPicture(this.place));
  }

  shown(panel) {
    return panel.curves.filter((curve) => !this.hidden.has(curve.group));
  }

  // The values that each panel shows: what was chosen; all usual ones; or those that are seen.
  ranges(width) {
    const isUsual = this.view.isAll() && !this.hidden.size;
    const fits = this.panels.map((panel) => {
      if (panel.words.length) return [-0.5, panel.words.length - 0.5];
      if (isUsual && panel.range) return panel.range;
      const curves = this.shown(panel);
      const decisive = curves.filter(({ isAside }) => !isAside);
      return (decisive.length ? decisive : curves).reduce(([low, high], { levels }) => {
        const [least, most] = levels.extremes(this.view.from, this.view.to, width);
        return [Math.min(low, least), Math.max(high, most)];
      }, [Infinity, -Infinity]);
    });
    const common = [Math.min(...fits.map(([low]) => low)), Math.max(...fits.map(([, high]) => high))];
    return this.panels.map((panel, n) => {
      if (panel.chosen) return panel.chosen;
      const fit = this.told.oneScale ? common : fits[n];
      return panel.words.length || (isUsual && panel.range) ? fit : roomAround(...fit);
    });
  }

  draw() {
    this.isDirty = false;
    const width = area(this.panels[0].canvas).width;
    const ranges = this.ranges(width);
    this.panels.forEach((panel, n) => {
      panel.shown = ranges[n];
      drawPanel(panel, this.shown(panel), this.view, this.told);
    });
    const { from, to } = this.view;
    Object.assign(this.place.dataset, { from, to });
  }

  // What the curves are at the cursors, and between them.
  measure() {
    const { A, B } = this.view.cursors;
    this.measured.replaceChildren();
    if (A === undefined && B === undefined) return;
    const head = element('tr', this.measured);
    const values = [A, B].map((time) => valueAt(this.told.across.scale, time));
    const apart = this.told.across.labels.length ? '–' : `${told(values[1] - values[0], 9)} ${this.told.unit}`;
    ['', `A: ${this.timeText(A)}`, `B: ${this.timeText(B)}`, `Δ: ${apart}`].forEach((text) => element('th', head, '', text));
    for (const panel of this.panels) {
      const of = panel.title || panel.quantity;
      for (const curve of this.shown(panel).filter(({ look }) => look !== 'marks')) {
        const [a, b] = [A, B].map((time) => (time === undefined ? undefined : valuesIn(panel, curve.levels.at(time))));
        const row = element('tr', this.measured);
        const name = element('td', row);
        element('i', name).style.borderColor = curve.colour;
        name.append(of && of !== curve.name ? `${curve.name} (${of})` : curve.name);
        for (const value of [a, b, difference(a, b)]) element('td', row, '', valueOf(value, curve, panel));
      }
    }
  }

  // A place from left to right as people read it.
  timeText(time) {
    const { unit, across } = this.told;
    if (time === undefined) return '–';
    if (across.labels.length) return across.labels[Math.round(time)] ?? '–';
    // By a logarithm there are no more digits.
    const digits = across.scale === 'logarithmic' ? 6 : 9;
    return `${told(valueAt(across.scale, time), digits)} ${unit}`.trim();
  }

  // What a curve is there; of a mark only as near as a finger's breadth.
  known(curve, time, reach) {
    const value = curve.levels.at(time);
    if (!value || curve.look !== 'marks') return value;
    return Math.abs(curve.levels.whole.times[value[2]] - time) <= reach ? value : undefined;
  }

  // Every curve at the pointer, with its value.
  tell(panel, event) {
    const { canvas } = panel;
    const place = area(canvas);
    const time = timeAt(this.view, canvas, event);
    const isOutside = event.offsetX < place.left || time > this.view.to;
    this.tip.hidden = isOutside;
    if (isOutside) return;
    const reach = (REACH / place.width) * (this.view.to - this.view.from);
    const known = this.shown(panel).map((curve) => ({ curve, value: this.known(curve, time, reach) }));
    const valued = known.filter(({ value }) => value);
    const at = panel.shown[1] - ((event.offsetY - place.top) / place.height) * (panel.shown[1] - panel.shown[0]);
    const off = ({ value: [low, high] }) => Math.max(low - at, at - high, 0);
    const nearest = valued.toSorted((a, b) => off(a) - off(b)).slice(0, MOST_TOLD);
    this.tip.replaceChildren();
    this.tip.classList.toggle('many', nearest.length > 12);
    // Where there are nothing but single points, it is theirs.
    const single = valued.length && valued.every(({ curve }) => curve.levels.isNearest) ? valued[0] : undefined;
    element('b', this.tip, '', this.timeText(single ? single.curve.levels.whole.times[single.value[2]] : time));
    for (const { curve, value } of valued.filter((one) => nearest.includes(one))) {
      const line = element('div', this.tip);
      element('i', line).style.borderColor = curve.colour;
      const words = curve.labels[value[2]];
      line.append(words ?? `${curve.name}: ${valueOf(valuesIn(panel, value), curve, panel)}${spreadOf(value, curve, panel)}`);
    }
    if (valued.length > nearest.length) element('div', this.tip, '', `${valued.length - nearest.length} more`);
    const isRight = event.offsetX > canvas.clientWidth / 2;
    this.tip.style.left = isRight ? 'auto' : `${event.offsetX + 16}px`;
    this.tip.style.right = isRight ? `${canvas.clientWidth - event.offsetX + 16}px` : 'auto';
    this.tip.style.top = `${canvas.offsetTop + 8}px`;
  }
}

// Places as values.
function valuesIn({ scale }, value) {
  return value?.slice(0, 2).map((place) => valueAt(scale, place));
}

// The spread of a point, if it has one.
function spreadOf([, , n], { levels, spread }, panel) {
  if (n === undefined || !spread[0].length) return '';
  const [low, high] = valuesIn(panel, [levels.whole.low[n], levels.whole.high[n]]).map((end) => told(end));
  return low === high ? '' : ` (${low} … ${high})`;
}

function difference(a, b) {
  return a && b ? [b[0] - a[1], b[1] - a[0]] : undefined;
}

// A value or the extremes of its stretch, with the unit; or its word.
function valueOf(value, curve, { words }) {
  if (!value) return '–';
  if (words.length) return words[Math.round(value[0])] ?? '–';
  const [low, high] = value.map((end) => told(end));
  return `${low === high ? low : `${low} … ${high}`} ${curve.unit}`.trim();
}

// --- Mouse and keys

function timeAt(view, canvas, event) {
  const place = area(canvas);
  return view.from + ((event.offsetX - place.left) / place.width) * (view.to - view.from);
}

function handle(figure, panel) {
  const { canvas } = panel;
  let drag;
  canvas.addEventListener('pointerdown', (event) => {
    const { view } = figure;
    drag = { x: event.offsetX, y: event.offsetY, from: view.from, to: view.to, time: timeAt(view, canvas, event) };
    drag.range = panel.chosen;
    drag.isMarking = event.shiftKey;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!drag || (!drag.moved && Math.abs(event.offsetX - drag.x) < 4)) {
      figure.tell(panel, event);
      return;
    }
    drag.moved = true;
    figure.tip.hidden = true;
    if (drag.isMarking) mark(figure.view, drag.time, timeAt(figure.view, canvas, event));
    else move(figure.view, panel, drag, event);
  });
  canvas.addEventListener('pointerup', (event) => {
    if (drag?.moved && drag.isMarking) showMarked(figure.view);
    else if (drag && !drag.moved) figure.view.set(event.shiftKey ? 'B' : 'A', drag.time);
    drag = undefined;
  });
  canvas.addEventListener('pointerleave', () => { figure.tip.hidden = true; });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const factor = 1.2 ** Math.sign(event.deltaY);
    const { view } = figure;
    if (event.offsetX < LEFT) zoomValues(figure, panel, event, factor);
    else view.show(...zoomed([view.from, view.to], timeAt(view, canvas, event), factor));
  }, { passive: false });
  canvas.addEventListener('dblclick', () => {
    figure.view.cursors = {};
    figure.view.set('A', undefined);
    figure.view.showAll();
  });
}

function move(view, panel, drag, event) {
  const place = area(panel.canvas);
  const by = ((drag.x - event.offsetX) / place.width) * (drag.to - drag.from);
  if (drag.range) {
    const up = ((event.offsetY - drag.y) / place.height) * (drag.range[1] - drag.range[0]);
    panel.chosen = drag.range.map((end) => end + up);
  }
  view.show(drag.from + by, drag.to + by);
}

function mark(view, from, to) {
  view.marked = [Math.min(from, to), Math.max(from, to)];
  view.redraw();
}

function showMarked(view) {
  const { marked } = view;
  view.marked = undefined;
  view.show(...marked);
}

function zoomValues(figure, panel, event, factor) {
  const place = area(panel.canvas);
  const [low, high] = panel.shown;
  const around = high - ((event.offsetY - place.top) / place.height) * (high - low);
  const chosen = zoomed([low, high], around, factor);
  for (const one of figure.told.oneScale ? figure.panels : [panel]) one.chosen = chosen;
  figure.view.redraw();
}

// --- When to draw

let isRequested = false;

function request() {
  if (isRequested) return;
  isRequested = true;
  requestAnimationFrame(() => {
    isRequested = false;
    drawSeen();
  });
}

// Those that are seen, or nearly; the others when they are.
function drawSeen() {
  for (const figure of [...figures, ...maps].filter(({ isDirty }) => isDirty)) {
    const { top, bottom } = figure.place.getBoundingClientRect();
    if (isPrinting || (bottom > -400 && top < innerHeight + 400)) figure.draw();
  }
}

function redrawAll() {
  for (const view of views.values()) view.redraw();
  for (const map of maps) map.isDirty = true;
  request();
}

const maps = [...document.querySelectorAll('.maps')].map((place) => new Maps(place));
const figures = [...document.querySelectorAll('.plot')].map((place) => new Figure(place));
for (const button of document.querySelectorAll('.places button')) {
  button.addEventListener('click', () => {
    const view = views.get('s');
    const { from, to } = button.dataset;
    if (from) view?.show(Number(from), Number(to));
    else view?.showAll();
  });
}
addEventListener('scroll', request, { passive: true });
addEventListener('resize', redrawAll);
addEventListener('keydown', ({ key }) => {
  if (key !== 'Escape') return;
  for (const view of views.values()) {
    view.cursors = {};
    view.set('A', undefined);
  }
});
isDark.addEventListener('change', redrawAll);
// Paper is white.
addEventListener('beforeprint', () => {
  isPrinting = true;
  redrawAll();
  drawSeen();
});
addEventListener('afterprint', () => {
  isPrinting = false;
  redrawAll();
});
redrawAll();
