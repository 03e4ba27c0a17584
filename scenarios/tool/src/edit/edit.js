'use strict';
// What editors share: asking, undoing, saving, and charts with points that can be dragged. Every number comes from the tool.

const byId = (id) => document.getElementById(id);

// An element with its properties and what is in it; text is text and never markup.
function make(tag, properties = {}, ...inside) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name in element && name !== 'list') element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...inside.filter((part) => part !== null && part !== undefined));
  return element;
}

// What is asked goes out one by one; of a drag only the newest waits.
const page = { asked: {}, answer: undefined, queue: [], isBusy: false, gesture: 0, shown: () => {} };

function ask(what, change, gesture) {
  const last = page.queue[page.queue.length - 1];
  const goesOn = gesture !== undefined && last && last.gesture === gesture;
  const said = { what, change, gesture };
  if (goesOn) page.queue[page.queue.length - 1] = said;
  else page.queue.push(said);
  sendNext();
}

// The right to change the file, as a part of the address that was printed when the page started.
const TOKEN = new URLSearchParams(location.search).get('token') ?? '';

async function sendNext() {
  if (page.isBusy || page.queue.length === 0) return;
  page.isBusy = true;
  const { what, change, gesture } = page.queue.shift();
  const body = JSON.stringify({ asked: page.asked, change: change ?? null, gesture: gesture ?? null });
  try {
    const response = await fetch(`do/${what}`, { method: 'POST', headers: { 'x-coaxle-page': TOKEN }, body });
    if (!response.ok) throw new Error(await response.text());
    page.answer = await response.json();
    showState(page.answer);
    page.shown(page.answer);
  } catch (error) {
    tell(String(error.message ?? error), true);
  }
  page.isBusy = false;
  document.body.dataset.answers = String(Number(document.body.dataset.answers ?? 0) + 1);
  sendNext();
}

function tell(text, isBad) {
  const place = byId('told');
  place.textContent = text;
  place.className = isBad ? 'bad' : 'good';
}

function showState(answer) {
  byId('undo').disabled = !answer.can_undo;
  byId('redo').disabled = !answer.can_redo;
  byId('save').disabled = answer.is_saved;
  const state = answer.is_new ? 'not saved yet' : answer.is_saved ? 'saved' : 'changed';
  const name = answer.file.split(/[\\/]/).pop();
  byId('file').textContent = `${name} — ${state}`;
  byId('file').title = answer.file;
  document.title = `${answer.is_saved ? '' : '• '}${name}`;
  if (answer.refused) tell(answer.refused, true);
  else tell(answer.told ?? '', false);
  const error = answer.view.error;
  byId('error').textContent = error ?? '';
  byId('error').hidden = !error;
  const text = byId('text');
  if (document.activeElement !== text) text.value = answer.text;
}

// A field for a number; what is no number goes nowhere.
function numberField(value, take, properties = {}) {
  const field = make('input', { type: 'number', step: 'any', ...properties });
  field.value = value ?? '';
  field.addEventListener('change', () => {
    if (field.value === '') take(null);
    else if (Number.isFinite(field.valueAsNumber)) take(field.valueAsNumber);
  });
  return field;
}

// Words to choose one of.
function choice(words, chosen, take, properties = {}) {
  const field = make('select', properties, ...words.map((word) => make('option', { value: word }, word)));
  field.value = chosen ?? '';
  field.addEventListener('change', () => take(field.value));
  return field;
}

// Is left alone while somebody types in it.
function refill(place, ...inside) {
  if (place.contains(document.activeElement) && document.activeElement.matches('input, select')) {
    const label = document.activeElement.getAttribute('aria-label');
    place.replaceChildren(...inside);
    const again = label && [...place.querySelectorAll('input, select')].find((e) => e.getAttribute('aria-label') === label);
    if (again) again.focus();
    return;
  }
  place.replaceChildren(...inside);
}

const CURVES = ['#2f86d6', '#0b9c78', '#d99a00', '#d9541e'];
const OTHER = '#8a5fc7';
const REACH = 9;

// Charts of several quantities over one axis, one above the other, with points that can be dragged.
// `handlers` are drag(point, quantity, along, value, grain, gesture), pick(point), insert(along, value, grain).
class Charts {
  constructor(place, handlers) {
    this.handlers = handlers;
    this.canvases = [0, 1, 2, 3].map((quantity) => {
      const canvas = make('canvas', { className: 'chart' });
      canvas.dataset.quantity = quantity;
      place.append(canvas);
      canvas.addEventListener('pointerdown', (event) => this.down(event, quantity));
      canvas.addEventListener('pointermove', (event) => this.move(event, quantity));
      canvas.addEventListener('pointerup', () => this.up());
      canvas.addEventListener('pointerleave', () => this.leave());
      canvas.addEventListener('dblclick', (event) => this.twice(event, quantity));
      return canvas;
    });
    this.along = make('p', { id: 'along' });
    place.append(this.along);
    this.drag = undefined;
    this.pointer = undefined;
    window.addEventListener('resize', () => this.draw());
  }

  show(data) {
    this.data = data;
    this.along.textContent = data.along ?? '';
    if (!this.drag) this.fit();
    this.draw();
  }

  fit() {
    const { curves, limits, points } = this.data;
    let [from, to] = [Infinity, -Infinity];
    for (const curve of curves) for (const along of curve.along) {
      if (along < from) from = along;
      if (along > to) to = along;
    }
    for (const point of points) if (curves.length === 0) [from, to] = [Math.min(from, point.along), Math.max(to, point.along)];
    if (!(from < to)) [from, to] = [0, 1];
    this.view = { from, to, zero: 0 };
    this.ranges = [0, 1, 2, 3].map((quantity) => {
      let [least, most] = [Infinity, -Infinity];
      const take = (value) => {
        if (value < least) least = value;
        if (value > most) most = value;
      };
      for (const curve of curves) for (const value of curve.values[quantity] ?? []) take(value);
      for (const point of points) if (point.at[quantity] !== undefined && !point.is_ignored) take(point.at[quantity]);
      if (least > most) return [-1, 1];
      // A limit far away must not flatten the curve.
      const height = most - least || Math.max(Math.abs(most), 1);
      for (const line of limits[quantity]) {
        const level = line.value ?? line;
        if (level > least - height && level < most + height) take(level);
      }
      return most - least > 1e-9 * Math.max(Math.abs(most), Math.abs(least), 1e-300) ? roomAround(least, most) : [least - 1, most + 1];
    });
  }

  place(quantity) {
    const canvas = this.canvases[quantity];
    const place = area(canvas);
    const [low, high] = this.ranges[quantity];
    const { from, to } = this.view;
    return {
      place,
      x: (along) => place.left + ((along - from) / (to - from)) * place.width,
      y: (value) => place.top + ((high - value) / (high - low)) * place.height,
      along: (x) => from + ((x - place.left) / place.width) * (to - from),
      value: (y) => high - ((y - place.top) / place.height) * (high - low),
      grain: [(to - from) / place.width, (high - low) / place.height],
    };
  }

  draw() {
    if (!this.data) return;
    for (const quantity of [0, 1, 2, 3]) this.drawOne(quantity);
  }

  drawOne(quantity) {
    const canvas = this.canvases[quantity];
    const pen = penOf(canvas);
    const style = getComputedStyle(document.body);
    const colour = (name) => style.getPropertyValue(name);
    const { place, x, y } = this.place(quantity);
    pen.fillStyle = colour('--quiet');
    pen.strokeStyle = colour('--rule');
    drawTimes(pen, place, this.view, x, '');
    drawValues(pen, place, this.ranges[quantity], y);
    pen.save();
    pen.beginPath();
    pen.rect(place.left, place.top, place.width, place.height);
    pen.clip();
    this.data.limits[quantity].forEach((line, n) => this.drawLimit(pen, place, y, line, n, colour('--bad')));
    this.data.curves.forEach((curve, n) => this.drawCurve(pen, curve, quantity, n, x, y));
    pen.restore();
    this.drawPoints(pen, quantity, x, y, colour);
    pen.fillStyle = colour('--text');
    pen.textAlign = 'left';
    pen.font = '12px system-ui, sans-serif';
    const heading = this.data.headings[quantity] ?? '';
    pen.fillStyle = colour('--text');
    pen.fillText(heading, place.left + 8, place.top + 15);
    this.drawPointer(pen, place, quantity, x, y, colour);
  }

  drawLimit(pen, place, y, line, n, colour) {
    const level = line.value ?? line;
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = 1;
    pen.setLineDash(line.binds === false ? [2, 4] : [6, 4]);
    pen.beginPath();
    pen.moveTo(place.left, y(level));
    pen.lineTo(place.left + place.width, y(level));
    pen.stroke();
    pen.setLineDash([]);
    pen.textAlign = 'right';
    if (!line.name) return;
    // Below its line where there is no room above, and beside those of another limit: each comes up and down.
    const isHigh = y(level) - place.top < 14;
    const right = place.left + place.width - 4 - (n >> 1) * (pen.measureText(line.name).width + 12);
    pen.fillText(line.name, right, y(level) + (isHigh ? 11 : -3));
  }

  drawCurve(pen, curve, quantity, n, x, y) {
    const values = curve.values[quantity] ?? [];
    pen.strokeStyle = n === 0 ? CURVES[quantity] : OTHER;
    pen.globalAlpha = curve.is_faint ? 0.35 : 1;
    pen.lineWidth = n === 0 ? 1.8 : 1.3;
    pen.setLineDash(n === 0 ? [] : [7, 4]);
    pen.beginPath();
    curve.along.forEach((along, k) => (k === 0 ? pen.moveTo(x(along), y(values[k])) : pen.lineTo(x(along), y(values[k]))));
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  drawPoints(pen, quantity, x, y, colour) {
    this.data.points.forEach((point, n) => {
      const value = point.at[quantity];
      if (value === undefined || (point.is_ignored && quantity > 0)) return;
      pen.beginPath();
      pen.arc(x(point.along), y(value), this.data.selected === n ? 6 : 4, 0, 2 * Math.PI);
      pen.fillStyle = this.data.selected === n ? colour('--bad') : colour('--page');
      pen.strokeStyle = point.is_ignored ? colour('--rule') : colour('--text');
      pen.lineWidth = 1.5;
      pen.fill();
      pen.stroke();
    });
  }

  // Where the pointer is; the nearest place that the tool has computed.
  drawPointer(pen, place, quantity, x, y, colour) {
    const curve = this.data.curves[0];
    if (this.pointer === undefined || !curve || curve.along.length === 0) return;
    let nearest = 0;
    curve.along.forEach((along, k) => {
      if (Math.abs(along - this.pointer) < Math.abs(curve.along[nearest] - this.pointer)) nearest = k;
    });
    const at = x(curve.along[nearest]);
    pen.strokeStyle = colour('--quiet');
    pen.lineWidth = 0.7;
    pen.beginPath();
    pen.moveTo(at, place.top);
    pen.lineTo(at, place.top + place.height);
    pen.stroke();
    pen.fillStyle = colour('--text');
    const isRight = at > place.left + place.width / 2;
    pen.textAlign = isRight ? 'right' : 'left';
    const words = `${told(curve.along[nearest], 5)}: ${told(curve.values[quantity][nearest], 5)}`;
    pen.fillText(words, at + (isRight ? -5 : 5), place.top + place.height - 5);
  }

  hit(event, quantity) {
    const { x, y } = this.place(quantity);
    let [found, distance] = [undefined, REACH];
    this.data.points.forEach((point, n) => {
      const value = point.at[quantity];
      if (value === undefined) return;
      const apart = Math.hypot(x(point.along) - event.offsetX, y(value) - event.offsetY);
      if (apart < distance) [found, distance] = [n, apart];
    });
    return found;
  }

  down(event, quantity) {
    if (!this.data || !this.handlers.drag) return;
    const point = this.hit(event, quantity);
    if (point === undefined) return;
    event.target.setPointerCapture(event.pointerId);
    this.drag = { point, quantity, gesture: ++page.gesture };
    this.handlers.pick(point);
  }

  move(event, quantity) {
    if (!this.data) return;
    const at = this.place(quantity);
    if (this.drag) {
      const { point, gesture } = this.drag;
      this.handlers.drag(point, quantity, at.along(event.offsetX), at.value(event.offsetY), at.grain, gesture);
      return;
    }
    this.pointer = at.along(event.offsetX);
    this.draw();
  }

  up() {
    if (!this.drag) return;
    this.drag = undefined;
    ask('view');
  }

  leave() {
    this.pointer = undefined;
    this.draw();
  }

  twice(event, quantity) {
    if (!this.data || quantity !== 0 || !this.handlers.insert || this.hit(event, quantity) !== undefined) return;
    const at = this.place(quantity);
    this.handlers.insert(at.along(event.offsetX), at.value(event.offsetY), at.grain);
  }
}

// The buttons that every editor has.
function begin(shown) {
  page.shown = shown;
  byId('undo').addEventListener('click', () => ask('undo'));
  byId('redo').addEventListener('click', () => ask('redo'));
  byId('save').addEventListener('click', () => ask('save'));
  byId('text').addEventListener('change', () => ask('change', { text: byId('text').value }));
  document.addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches('input, textarea, select')) return;
    const key = event.key.toLowerCase();
    if (key === 's') ask('save');
    else if (key === 'z') ask(event.shiftKey ? 'redo' : 'undo');
    else if (key === 'y') ask('redo');
    else return;
    event.preventDefault();
  });
  window.addEventListener('beforeunload', (event) => {
    if (page.answer && !page.answer.is_saved && page.answer.can_undo) event.preventDefault();
  });
  ask('view');
}
