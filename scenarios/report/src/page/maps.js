'use strict';
// Maps: coloured cells over two axes, zoomed and moved together.

const MAP_HEIGHT = 340;

class Maps {
  constructor(place) {
    const told = JSON.parse(document.getElementById(`${place.id}-figure`).textContent);
    Object.assign(this, { place, told, isDirty: true });
    this.all = [told.across.labels, told.up.labels].map(({ length }) => [-0.5, length - 0.5]);
    this.view = this.all;
    this.bar();
    const grid = element('div', place, 'grid');
    grid.style.gridTemplateColumns = `repeat(${told.columns}, 1fr)`;
    this.maps = told.maps.map((map) => {
      const part = element('div', grid);
      element('div', part, 'panel-title', map.title);
      const canvas = element('canvas', part);
      canvas.style.height = `${MAP_HEIGHT}px`;
      handleMap(this, canvas);
      return { ...map, canvas };
    });
    this.tip = element('div', place, 'tip');
    this.tip.hidden = true;
  }

  // What the colours mean.
  bar() {
    if (!this.told.range) return;
    const bar = element('div', this.place, 'bar');
    const [low, high] = this.told.range;
    element('span', bar, '', low);
    element('i', bar).style.background = `linear-gradient(to right, ${this.told.colours.join(',')})`;
    element('span', bar, '', high);
    const keep = element('button', bar, 'keep', 'save as PNG');
    keep.addEventListener('click', () => keepPicture(this.place, this.told.colours));
  }

  // The place of a map's cells on its canvas: the words beside it may be long.
  area(canvas, pen) {
    const words = this.told.up.labels.map((word) => pen.measureText(word).width);
    const left = Math.min(canvas.clientWidth / 3, Math.max(30, ...words) + 26);
    return { left, top: 4, width: Math.max(1, canvas.clientWidth - left - 10), height: MAP_HEIGHT - 44 };
  }

  show(view) {
    this.view = view.map(([low, high], n) => {
      const [first, last] = this.all[n];
      const span = Math.min(last - first, Math.max(1, high - low));
      const from = Math.min(Math.max(first, low), last - span);
      return [from, from + span];
    });
    this.isDirty = true;
    request();
  }

  draw() {
    this.isDirty = false;
    for (const map of this.maps) this.drawMap(map);
  }

  drawMap(map) {
    const { canvas, cells } = map;
    const { across, colours: shades } = this.told;
    const pen = penOf(canvas);
    const place = this.area(canvas, pen);
    const [[left, right], [low, high]] = this.view;
    const each = [place.width / (right - left), place.height / (high - low)];
    const x = (column) => place.left + (column - left) * each[0];
    const y = (row) => place.top + (high - row) * each[1];
    Object.assign(map, { area: place, each });
    pen.save();
    pen.beginPath();
    pen.rect(place.left, place.top, place.width, place.height);
    pen.clip();
    pen.textAlign = 'center';
    cells.forEach((value, n) => {
      if (value === null) return;
      const [column, row] = [n % across.labels.length, Math.floor(n / across.labels.length)];
      pen.fillStyle = shades[map.colours[n]];
      pen.fillRect(x(column - 0.5), y(row + 0.5), each[0] + 0.5, each[1] + 0.5);
      const text = told(value, 3);
      if (each[1] < 14 || each[0] < pen.measureText(text).width + 4) return;
      pen.fillStyle = map.colours[n] < shades.length / 2 ? '#ffffff' : '#000000';
      pen.fillText(text, x(column), y(row) + 4);
    });
    pen.restore();
    this.drawWords(pen, place, x, y);
  }

  drawWords(pen, place, x, y) {
    const { across, up } = this.told;
    const bottom = place.top + place.height;
    pen.fillStyle = colours().quiet;
    pen.textAlign = 'center';
    const longest = Math.max(10, ...across.labels.map((word) => pen.measureText(word).width));
    for (const { at, text } of someWords(across.labels, this.view[0], place.width / (longest + 12))) {
      pen.fillText(text, x(at), bottom + 14);
    }
    pen.fillText(across.words, place.left + place.width / 2, bottom + 32);
    pen.textAlign = 'right';
    for (const { at, text } of someWords(up.labels, this.view[1], place.height / 16)) {
      pen.fillText(text, place.left - 5, y(at) + 4);
    }
    pen.textAlign = 'center';
    pen.translate(11, place.top + place.height / 2);
    pen.rotate(-Math.PI / 2);
    pen.fillText(up.words, 0, 0);
  }

  // The column and the row that a point of the canvas lies in, between its middles.
  at(map, event) {
    const [[left], [, high]] = this.view;
    return [left + (event.offsetX - map.area.left) / map.each[0], high - (event.offsetY - map.area.top) / map.each[1]];
  }

  tell(map, event) {
    const { across, up } = this.told;
    const [column, row] = this.at(map, event).map(Math.round);
    const value = map.cells[row * across.labels.length + column];
    const isInside = event.offsetX >= map.area.left && event.offsetY <= map.area.top + map.area.height;
    this.tip.hidden = !isInside || across.labels[column] === undefined || up.labels[row] === undefined;
    if (this.tip.hidden) return;
    this.tip.replaceChildren();
    element('b', this.tip, '', map.title);
    element('div', this.tip, '', `${across.words}: ${across.labels[column]}`);
    element('div', this.tip, '', `${up.words}: ${up.labels[row]}`);
    element('div', this.tip, '', value === null ? '–' : told(value));
    const { left, top, width } = map.canvas.getBoundingClientRect();
    const frame = this.place.getBoundingClientRect();
    const isRight = event.offsetX > width / 2;
    this.tip.style.left = isRight ? 'auto' : `${left - frame.left + event.offsetX + 16}px`;
    this.tip.style.right = isRight ? `${frame.right - left - event.offsetX + 16}px` : 'auto';
    this.tip.style.top = `${top - frame.top + event.offsetY + 12}px`;
  }
}

function handleMap(maps, canvas) {
  const own = () => maps.maps.find((map) => map.canvas === canvas);
  let drag;
  canvas.addEventListener('pointerdown', (event) => {
    drag = { x: event.offsetX, y: event.offsetY, view: maps.view };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!drag) {
      maps.tell(own(), event);
      return;
    }
    const { each } = own();
    const by = [(drag.x - event.offsetX) / each[0], (event.offsetY - drag.y) / each[1]];
    maps.tip.hidden = true;
    maps.show(drag.view.map((range, n) => range.map((end) => end + by[n])));
  });
  canvas.addEventListener('pointerup', () => { drag = undefined; });
  canvas.addEventListener('pointerleave', () => { maps.tip.hidden = true; });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const factor = 1.2 ** Math.sign(event.deltaY);
    const around = maps.at(own(), event);
    maps.show(maps.view.map((range, n) => zoomed(range, around[n], factor)));
  }, { passive: false });
  canvas.addEventListener('dblclick', () => maps.show(maps.all));
}
